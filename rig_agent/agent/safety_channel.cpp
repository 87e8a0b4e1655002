#include "rig_agent/agent/safety_channel.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <utility>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/runtime/drain.hpp"

namespace tonus::rig {
namespace {

constexpr std::chrono::milliseconds kPoll{100};
constexpr std::chrono::milliseconds kUnconfirmedPoll{1};
constexpr std::size_t kStopsKept = 64;

}  // namespace

class SafetyChannel::Work {
 public:
  Work(std::unique_ptr<bus::Bus> bus, bus::TypedReader<v1::RigStop> stops,
       bus::TypedReader<v1::RigLease> leases, bus::TypedWriter<v1::RigStop> stopped,
       std::shared_ptr<bus::Notifier> notifier, const Id& rig, control::RigLoop& loop, Lease& lease,
       StopRequests& requests, const Clock& clock, std::shared_ptr<bus::Notifier> wake)
      : bus_(std::move(bus)),
        stops_(std::move(stops)),
        leases_(std::move(leases)),
        stopped_(std::move(stopped)),
        notifier_(std::move(notifier)),
        rig_(rig),
        loop_(loop),
        lease_(lease),
        requests_(requests),
        clock_(clock),
        wake_(std::move(wake)) {}

  void run() {
    while (!is_ending_.load(std::memory_order_acquire)) (void)notifier_->wait_until(step());
  }

  Clock::TimePoint step() {
    for (const auto& received : runtime::drain(stops_)) take_stop(received.value);
    for (const auto& received : runtime::drain(leases_)) lease_.hear(received.value, clock_.now());
    confirm();
    return clock_.now() + (unconfirmed_.empty() ? kPoll : kUnconfirmedPoll);
  }

  [[nodiscard]] const std::shared_ptr<bus::Notifier>& notifier() const { return notifier_; }

  void end() {
    is_ending_.store(true, std::memory_order_release);
    notifier_->notify();
  }

 private:
  /// A repeat of a stop that was confirmed stops nothing anew: it may be late, and the rig cleared meanwhile.
  void take_stop(const v1::RigStop& stop) {
    if (stop.rig_id() != rig_) return;
    if (std::find(confirmed_.begin(), confirmed_.end(), stop.stop_id()) != confirmed_.end()) {
      (void)stopped_.write(stop);
      return;
    }
    loop_.emergency_stop();
    const auto is_same = [&stop](const v1::RigStop& other) { return other.stop_id() == stop.stop_id(); };
    if (std::any_of(unconfirmed_.begin(), unconfirmed_.end(), is_same)) return;
    requests_.add(stop.requested_by());
    unconfirmed_.push_back(stop);
    if (unconfirmed_.size() > kStopsKept) unconfirmed_.pop_front();
    wake_->notify();
  }

  void confirm() {
    if (unconfirmed_.empty()) return;
    if ((loop_.state().faults & control::bit(control::Fault::kEmergencyStop)) == 0) return;
    for (const v1::RigStop& stop : unconfirmed_) {
      (void)stopped_.write(stop);  // lost: the sender's next repeat is confirmed
      confirmed_.push_back(stop.stop_id());
    }
    unconfirmed_.clear();
    while (confirmed_.size() > kStopsKept) confirmed_.pop_front();
  }

  std::unique_ptr<bus::Bus> bus_;
  bus::TypedReader<v1::RigStop> stops_;
  bus::TypedReader<v1::RigLease> leases_;
  bus::TypedWriter<v1::RigStop> stopped_;
  std::shared_ptr<bus::Notifier> notifier_;
  const Id rig_;
  control::RigLoop& loop_;
  Lease& lease_;
  StopRequests& requests_;
  const Clock& clock_;
  std::shared_ptr<bus::Notifier> wake_;
  std::deque<v1::RigStop> unconfirmed_;
  std::deque<Id> confirmed_;
  // Written by end() (release), read by the thread (acquire).
  std::atomic<bool> is_ending_{false};
};

Result<std::unique_ptr<SafetyChannel>> SafetyChannel::create(std::unique_ptr<bus::Bus> bus, const Id& rig,
                                                             control::RigLoop& loop, Lease& lease,
                                                             StopRequests& stops, const Clock& clock,
                                                             std::shared_ptr<bus::Notifier> wake,
                                                             Works works) {
  auto notifier = std::make_shared<bus::Notifier>();
  TONUS_TRY_ASSIGN(auto stop_reader, bus::TypedReader<v1::RigStop>::create(*bus, topics::kRigStop, notifier));
  TONUS_TRY_ASSIGN(auto lease_reader,
                   bus::TypedReader<v1::RigLease>::create(*bus, topics::kRigLease, notifier));
  TONUS_TRY_ASSIGN(auto stopped, bus::TypedWriter<v1::RigStop>::create(*bus, topics::kRigStopped));
  auto work =
      std::make_unique<Work>(std::move(bus), std::move(stop_reader), std::move(lease_reader),
                             std::move(stopped), notifier, rig, loop, lease, stops, clock, std::move(wake));
  return std::unique_ptr<SafetyChannel>(new SafetyChannel(std::move(work), works));
}

SafetyChannel::SafetyChannel(std::unique_ptr<Work> work, Works works) : work_(std::move(work)) {
  if (works == Works::kInOwnThread) thread_ = std::thread([this] { work_->run(); });
}

SafetyChannel::~SafetyChannel() {
  work_->end();
  if (thread_.joinable()) thread_.join();
}

Clock::TimePoint SafetyChannel::step() { return work_->step(); }

const std::shared_ptr<bus::Notifier>& SafetyChannel::notifier() const { return work_->notifier(); }

}  // namespace tonus::rig
