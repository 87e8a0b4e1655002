#include "analysis_service/service/rigs_service.hpp"

#include <utility>

namespace tonus::identification {

Result<RigParts> RigParts::create(bus::Bus& bus, const Clock& clock, const runtime::CommonOptions& common,
                                  const ServiceSettings& settings) {
  auto notifier = std::make_shared<bus::Notifier>();
  TONUS_TRY_ASSIGN(auto endpoints, ServiceEndpoints::create(bus, notifier));
  TONUS_TRY_ASSIGN(auto health,
                   runtime::HealthReporter::create(bus, clock, v1::ROLE_IDENTIFICATION, common, notifier));
  TONUS_TRY_ASSIGN(auto roster, runtime::Roster::create(bus, clock, notifier));
  return RigParts{settings, std::move(endpoints), std::move(health), std::move(roster), std::move(notifier)};
}

RigsService::RigsService(std::vector<RigParts> rigs, const Clock& clock, std::shared_ptr<bus::Notifier> ended)
    : ended_(std::move(ended)) {
  for (RigParts& parts : rigs) {
    rigs_.push_back(
        {std::make_unique<IdentificationService>(parts.settings, std::move(parts.endpoints),
                                                 std::move(parts.health), std::move(parts.roster), clock),
         std::move(parts.notifier), std::thread()});
  }
  for (Rig& rig : rigs_) rig.thread = std::thread([this, &rig] { serve(rig); });
}

RigsService::~RigsService() { (void)finish(); }

void RigsService::serve(Rig& rig) {
  while (true) {
    if (const auto alone = rig.service->check_alone(); !alone) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = alone.error();
      has_failed_.store(true, std::memory_order_release);
      ended_->notify();
      return;
    }
    const Clock::TimePoint due = rig.service->step();
    if (!is_ending_.load(std::memory_order_acquire)) (void)rig.notifier->wait_until(due);
    if (is_ending_.load(std::memory_order_acquire)) break;
  }
  rig.service->finish();
}

Result<void> RigsService::finish() {
  is_ending_.store(true, std::memory_order_release);
  for (Rig& rig : rigs_) rig.notifier->notify();
  for (Rig& rig : rigs_) {
    if (rig.thread.joinable()) rig.thread.join();
  }
  const std::lock_guard lock(mutex_);
  if (error_) return *error_;
  return {};
}

}  // namespace tonus::identification
