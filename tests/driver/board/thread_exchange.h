// Ranks that are threads of one process.
#pragma once

#include <barrier>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include "gicube/ray_exchange.h"

namespace gicube::reference {

class ThreadRanks {
 public:
  explicit ThreadRanks(int ranks)
      : all_(ranks), box_(static_cast<std::size_t>(ranks)), values_(static_cast<std::size_t>(ranks)) {
    for (auto& row : box_) row.resize(box_.size());
  }

  std::size_t ranks() const { return box_.size(); }
  // A rank's, for calls within run(). This must outlive it.
  std::shared_ptr<RayExchange> exchange(std::size_t rank) { return std::make_shared<Exchange>(*this, rank); }

  // Calls body(exchange) on a thread for each rank. Returns what each threw, or null; if one threw, there is no other
  // run.
  std::vector<std::exception_ptr> run(const std::function<void(RayExchange&)>& body) {
    std::vector<std::exception_ptr> errors(ranks());
    std::vector<std::jthread> threads;
    for (std::size_t rank = 0; rank < ranks(); ++rank) {
      threads.emplace_back([&, rank] {
        try {
          body(*exchange(rank));
        } catch (...) {
          errors[rank] = std::current_exception();
          all_.arrive_and_drop();  // others go on without it
        }
      });
    }
    threads.clear();
    return errors;
  }

 private:
  using Messages = std::vector<std::vector<std::uint8_t>>;

  class Exchange : public RayExchange {
   public:
    Exchange(ThreadRanks& all, std::size_t rank) : all_(all), rank_(rank) {}
    int rank() const override { return static_cast<int>(rank_); }
    int ranks() const override { return static_cast<int>(all_.ranks()); }
    Messages exchange(Messages to) override {
      for (std::size_t r = 0; r < to.size(); ++r) all_.box_[r][rank_] = std::move(to[r]);
      all_.all_.arrive_and_wait();
      Messages from = all_.box_[rank_];
      all_.all_.arrive_and_wait();
      return from;
    }
    std::uint64_t sum(std::uint64_t value) override {
      all_.values_[rank_] = value;
      all_.all_.arrive_and_wait();
      const std::uint64_t total = std::accumulate(all_.values_.begin(), all_.values_.end(), std::uint64_t{0});
      all_.all_.arrive_and_wait();
      return total;
    }

   private:
    ThreadRanks& all_;
    std::size_t rank_;
  };

  std::barrier<> all_;
  std::vector<Messages> box_;  // by receiver, then by sender
  std::vector<std::uint64_t> values_;
};

}  // namespace gicube::reference
