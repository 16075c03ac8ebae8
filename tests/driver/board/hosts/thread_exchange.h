// Ranks that are threads of one process.
#pragma once

#include <barrier>
#include <exception>
#include <functional>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include "gicube/ray_exchange.h"

namespace gicube::reference {

class ThreadRanks {
 public:
  explicit ThreadRanks(int ranks)
      : ranks_(ranks), all_(ranks), box_(static_cast<std::size_t>(ranks)), values_(static_cast<std::size_t>(ranks)) {
    for (auto& row : box_) row.resize(box_.size());
  }

  // Calls body(exchange) on a thread for each rank. Returns what each threw, or null.
  std::vector<std::exception_ptr> run(const std::function<void(RayExchange&)>& body) {
    std::vector<std::exception_ptr> errors(box_.size());
    {
      std::vector<std::jthread> threads;
      for (int rank = 0; rank < ranks_; ++rank) {
        threads.emplace_back([&, rank] {
          Exchange exchange(*this, rank);
          try {
            body(exchange);
          } catch (...) {
            errors[static_cast<std::size_t>(rank)] = std::current_exception();
          }
          all_.arrive_and_drop();
        });
      }
    }
    return errors;
  }

 private:
  using Messages = std::vector<std::vector<std::uint8_t>>;

  class Exchange : public RayExchange {
   public:
    Exchange(ThreadRanks& all, int rank) : all_(all), rank_(rank) {}
    int rank() const override { return rank_; }
    int ranks() const override { return all_.ranks_; }
    Messages exchange(Messages to) override {
      const auto me = static_cast<std::size_t>(rank_);
      for (std::size_t r = 0; r < to.size(); ++r) all_.box_[r][me] = std::move(to[r]);
      all_.all_.arrive_and_wait();
      Messages from = all_.box_[me];
      all_.all_.arrive_and_wait();
      return from;
    }
    std::uint64_t sum(std::uint64_t value) override {
      all_.values_[static_cast<std::size_t>(rank_)] = value;
      all_.all_.arrive_and_wait();
      const std::uint64_t total = std::accumulate(all_.values_.begin(), all_.values_.end(), std::uint64_t{0});
      all_.all_.arrive_and_wait();
      return total;
    }

   private:
    ThreadRanks& all_;
    int rank_;
  };

  int ranks_;
  std::barrier<> all_;
  std::vector<Messages> box_;  // by receiver, then by sender
  std::vector<std::uint64_t> values_;
};

}  // namespace gicube::reference
