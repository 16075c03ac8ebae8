// Authentication of callers of the management plane over TCP.
#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "management.h"
#include "server/bus/back_off.h"
#include "server/bus/session.h"

namespace gicube::emu {

// Requires a token for each call, including health and reflection. Refusals of wrong tokens are delayed with increasing
// pauses, to slow down guessing. Only a few are delayed at a time, because each occupies a thread.
class TokenCheck final : public grpc::AuthMetadataProcessor {
 public:
  TokenCheck(std::vector<AccessToken> tokens, Audit* audit) : tokens_(std::move(tokens)), audit_(audit) {}

  bool IsBlocking() const override { return true; }

  // The token stays in the call's metadata. Each call checks its right with right_in().
  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext*, OutputMetadata*, OutputMetadata*) override {
    if (right_in(metadata)) return grpc::Status::OK;
    hold_back(metadata.find(kHeader) != metadata.end());
    return {grpc::StatusCode::UNAUTHENTICATED, "expected the metadata \"authorization: Bearer TOKEN\""};
  }

  std::optional<Right> right_in(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata) const {
    const auto found = metadata.find(kHeader);
    if (found == metadata.end()) return std::nullopt;
    return right_of(tokens_, bearer_token({found->second.data(), found->second.size()}));
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    stopped_.notify_all();
  }

 private:
  using Clock = BackOff::Clock;
  static constexpr const char* kHeader = "authorization";

  void hold_back(bool has_one) {
    constexpr int kMaxHeld = 4;  // chosen
    if (audit_ != nullptr) {
      audit_->note(AuditEvent::kUnknown, "management caller", has_one ? "its token is wrong" : "it has no token");
    }
    std::unique_lock lock(mutex_);
    if (held_ >= kMaxHeld) return;
    ++held_;
    wrong_.happened(Clock::now());
    stopped_.wait_for(lock, wrong_.left(Clock::now()), [this] { return stopping_; });
    --held_;
  }

  const std::vector<AccessToken> tokens_;
  Audit* const audit_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  BackOff wrong_{BusOptions().token_pause, BusOptions().longest_token_pause};
  int held_ = 0;
  bool stopping_ = false;
};

}  // namespace gicube::emu
