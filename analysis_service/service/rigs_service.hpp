#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "analysis_service/service/service.hpp"

namespace tonus::identification {

/// What one rig's IdentificationService is made of, and what wakes it.
struct RigParts {
  ServiceSettings settings;
  ServiceEndpoints endpoints;
  runtime::HealthReporter health;
  runtime::Roster roster;
  std::shared_ptr<bus::Notifier> notifier;

  /// On the rig's own bus; `common` names the rig.
  [[nodiscard]] static Result<RigParts> create(bus::Bus& bus, const Clock& clock,
                                               const runtime::CommonOptions& common,
                                               const ServiceSettings& settings);
};

/// Identification of one or several rigs in one process. What belongs to a rig (its ends of the bus, its
/// trials, its health) is its IdentificationService's alone, and has a thread of its own: a rig that is slow,
/// or whose estimates take long, delays no other's. Ends with the first of them that cannot go on.
class RigsService {
 public:
  /// `ended` is notified when one cannot go on. Starts the threads.
  RigsService(std::vector<RigParts> rigs, const Clock& clock, std::shared_ptr<bus::Notifier> ended);
  ~RigsService();
  RigsService(const RigsService&) = delete;
  RigsService& operator=(const RigsService&) = delete;

  [[nodiscard]] bool has_failed() const { return has_failed_.load(std::memory_order_acquire); }

  /// Ends all, each as IdentificationService::finish(). Returns the error of the first that could not go on.
  [[nodiscard]] Result<void> finish();

 private:
  struct Rig {
    std::unique_ptr<IdentificationService> service;
    std::shared_ptr<bus::Notifier> notifier;
    std::thread thread;
  };
  void serve(Rig& rig);

  std::shared_ptr<bus::Notifier> ended_;
  std::atomic<bool> is_ending_ = false;
  std::atomic<bool> has_failed_ = false;
  std::mutex mutex_;
  std::optional<Error> error_;  ///< The first.
  std::vector<Rig> rigs_;
};

}  // namespace tonus::identification
