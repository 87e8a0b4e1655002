#include "services/scheduler/lease_sender.hpp"

#include <mutex>
#include <utility>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"

namespace tonus::scheduler {
namespace {

constexpr std::chrono::milliseconds kPeriod{100};

}  // namespace

class LeaseSender::Work {
 public:
  Work(std::unique_ptr<bus::Bus> bus, bus::TypedWriter<v1::RigLease> writer, const Clock& clock)
      : bus_(std::move(bus)), writer_(std::move(writer)), clock_(clock) {}

  void set(const std::optional<v1::RigLease>& lease) {
    const std::lock_guard lock(mutex_);
    const bool is_other = lease != lease_;
    lease_ = lease;
    set_at_ = clock_.now();
    if (is_other) changed_.notify();
  }

  void run() {
    while (const auto due = step()) (void)changed_.wait_until(*due);
  }

  /// When to go on at the latest; none: it is to end.
  std::optional<Clock::TimePoint> step() {
    const std::lock_guard lock(mutex_);
    if (is_ending_) return std::nullopt;
    if (lease_ && clock_.now() - set_at_ <= kLongestSilence) send(*lease_);
    return clock_.now() + kPeriod;
  }

  void end() {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    changed_.notify();
  }

 private:
  void send(v1::RigLease lease) {
    lease.number(++number_);
    (void)writer_.write(lease);  // lost: the next one follows
  }

  std::unique_ptr<bus::Bus> bus_;
  bus::TypedWriter<v1::RigLease> writer_;
  const Clock& clock_;
  bus::Notifier changed_;
  std::mutex mutex_;
  std::optional<v1::RigLease> lease_;
  Clock::TimePoint set_at_;
  std::uint64_t number_ = 0;
  bool is_ending_ = false;
};

Result<std::unique_ptr<LeaseSender>> LeaseSender::create(std::unique_ptr<bus::Bus> bus, const Clock& clock,
                                                         Works works) {
  TONUS_TRY_ASSIGN(auto writer, bus::TypedWriter<v1::RigLease>::create(*bus, topics::kRigLease));
  auto work = std::make_unique<Work>(std::move(bus), std::move(writer), clock);
  return std::unique_ptr<LeaseSender>(new LeaseSender(std::move(work), works));
}

LeaseSender::LeaseSender(std::unique_ptr<Work> work, Works works) : work_(std::move(work)) {
  if (works == Works::kInOwnThread) thread_ = std::thread([this] { work_->run(); });
}

LeaseSender::~LeaseSender() {
  work_->end();
  if (thread_.joinable()) thread_.join();
}

void LeaseSender::set(const std::optional<v1::RigLease>& lease) { work_->set(lease); }

Clock::TimePoint LeaseSender::step() { return work_->step().value_or(Clock::TimePoint::max()); }

}  // namespace tonus::scheduler
