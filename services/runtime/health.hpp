#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/bus.hpp"
#include "services/bus/typed.hpp"
#include "services/core/clock.hpp"
#include "services/core/id.hpp"
#include "services/core/lifetime.hpp"
#include "services/runtime/clock_answer.hpp"
#include "services/runtime/options.hpp"

#include <idl/service.h>

namespace tonus::runtime {

/// "rig", "scheduler", "identification", "archive", "dashboard" or "operator".
[[nodiscard]] const char* role_name(v1::ServiceRole role);

/// Hash of the contract that this program was built from.
[[nodiscard]] Id idl_hash();

/// What a service says of itself. Its health: at once when it changes, else every half second, and a last
/// word when it ends. What it was started with: once. Its clock: to whoever asks.
class HealthReporter {
 public:
  /// The notifier is that of the service's loop: it is woken when its clock is asked for. Without one the
  /// answer waits for the next report.
  [[nodiscard]] static Result<HealthReporter> create(bus::Bus& bus, const Clock& clock, v1::ServiceRole role,
                                                     const CommonOptions& options,
                                                     std::shared_ptr<bus::Notifier> notifier = nullptr);
  HealthReporter(HealthReporter&& other) noexcept;
  HealthReporter& operator=(HealthReporter&&) = delete;
  ~HealthReporter();

  /// `state` is a line for a person: what it does, or what is missing where it is not ready.
  void set_state(bool is_ready, const std::string& state);
  /// What a person should know although the service works; at most 16 are published.
  void set_warnings(std::vector<std::string> warnings);
  void set_load(double lag_s, std::uint32_t queue_depth, std::uint64_t dropped);

  /// Publishes if it is due, and answers those who ask for the clock; returns when it is due next.
  Clock::TimePoint publish_if_due();

  [[nodiscard]] Id instance() const { return health_.instance_id(); }

  /// Another process that goes on reporting under this service's role and name, with process and host: two
  /// must not serve one rig, and this one is then not ready. Empty: none was heard of late.
  [[nodiscard]] std::string other() const;

  /// kAlreadyExists with other() where this process is the second of two: it has just started, and the other
  /// had started before. It should end; until it has, the first one goes on as ready.
  [[nodiscard]] Result<void> check_alone() const;

 private:
  HealthReporter(bus::TypedWriter<v1::ServiceHealth> writer,
                 bus::TypedWriter<v1::ServiceConfiguration> configuration,
                 bus::TypedReader<v1::ServiceHealth> others, ClockAnswer clock_answer, const Clock& clock,
                 v1::ServiceHealth health);
  void publish();
  void hear_others();
  [[nodiscard]] bool is_older_than_other() const;

  std::optional<bus::TypedWriter<v1::ServiceHealth>> writer_;
  bus::TypedWriter<v1::ServiceConfiguration> configuration_;  ///< Kept, for late joiners.
  bus::TypedReader<v1::ServiceHealth> others_;
  ClockAnswer clock_answer_;
  const Clock* clock_;
  v1::ServiceHealth health_;
  /// Reports of another process of this role and name; one that has been replaced reports no more.
  struct Other {
    v1::ServiceHealth health;
    int reports = 0;
    Clock::TimePoint heard;
  };
  std::optional<Other> other_;
  Clock::TimePoint begun_;
  Clock::TimePoint due_;
  bool has_changed_ = true;
};

/// On a lab's network, before a service begins to act: it reports that it is not ready yet and hears for 4 s
/// whether another of its role and rig does, on whatever host. kAlreadyExists as
/// HealthReporter::check_alone(). Returns at once on one machine alone, where locks and folders keep a second
/// one out, and soon after the stop signal.
[[nodiscard]] Result<void> listen_for_others(HealthReporter& health, const CommonOptions& options,
                                             const Clock& clock, bus::Notifier& notifier,
                                             const StopSignal& stop);

/// How a service differs from this program in contract or version, with its host; empty: it does not.
[[nodiscard]] std::string difference(const v1::ServiceHealth& health);

/// What is known of all services from their health: who is there, ready, and of the same contract and
/// version.
class Roster {
 public:
  /// A service that has not been heard of for this long is gone: four missed reports.
  static constexpr std::chrono::milliseconds kSilence{2000};

  [[nodiscard]] static Result<Roster> create(bus::Bus& bus, const Clock& clock,
                                             std::shared_ptr<bus::Notifier> notifier);

  /// Takes what has arrived. Call before asking.
  void update();

  /// The newest health of every service that is there.
  [[nodiscard]] std::vector<v1::ServiceHealth> present() const;

  /// Newest health of a role, if such a service is there.
  [[nodiscard]] std::optional<v1::ServiceHealth> find(v1::ServiceRole role) const;

  /// How many reports of a role's service have been taken since it appeared; 0: it is not there.
  [[nodiscard]] std::uint64_t reports(v1::ServiceRole role) const;

  /// Reports that this program's contract cannot read: those of another version.
  [[nodiscard]] std::uint64_t unreadable() const { return reader_.status().malformed; }

  /// Empty if each of `roles` is there, of this program's contract and version, and ready; else a line that
  /// says of each one that is not what is wrong with it. With `must_be_ready` false a service need only be
  /// there.
  [[nodiscard]] std::string missing(const std::vector<v1::ServiceRole>& roles,
                                    bool must_be_ready = true) const;

 private:
  struct Entry {
    v1::ServiceHealth health;
    Clock::TimePoint heard;
    std::uint64_t reports = 0;
  };
  Roster(bus::TypedReader<v1::ServiceHealth> reader, const Clock& clock);

  bus::TypedReader<v1::ServiceHealth> reader_;
  const Clock* clock_;
  std::map<Id, Entry> entries_;
};

}  // namespace tonus::runtime
