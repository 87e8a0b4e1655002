#include "services/runtime/health.hpp"

#include <algorithm>
#include <array>
#include <spdlog/fmt/fmt.h>
#include <tuple>
#include <unistd.h>
#include <utility>

#include "idl/topics.hpp"
#include "services/runtime/configuration.hpp"
#include "services/runtime/drain.hpp"
#include "services/runtime/refused_packets_log.hpp"
#include "services/runtime/service_manager.hpp"
#include "services/runtime/version.hpp"

#include <idl/idl_hash.hpp>

namespace tonus::runtime {
namespace {

constexpr std::chrono::milliseconds kPeriod{500};
constexpr int kReportsOfAnother = 3;  // one that was just replaced may still be heard once
constexpr int kReportsOfSecond = 8;   // a second one has ended by then
constexpr std::chrono::seconds kNew{10};
constexpr std::chrono::seconds kListening{4};  // discovery, and kReportsOfAnother reports
constexpr std::chrono::seconds kOtherForgotten{3};
constexpr std::size_t kMostWarnings = 16;  // the contract's bound

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

v1::ServiceConfiguration configuration_of(const v1::ServiceHealth& health, const CommonOptions& options) {
  v1::ServiceConfiguration configuration;
  configuration.instance_id(health.instance_id());
  configuration.role(health.role());
  configuration.name(health.name());
  configuration.software_version(health.software_version());
  configuration.build(build_text());
  configuration.configuration_toml(options.configuration);
  configuration.started_ns(health.started_ns());
  return configuration;
}

}  // namespace

const char* role_name(v1::ServiceRole role) {
  switch (role) {
    case v1::ROLE_RIG:
      return "rig";
    case v1::ROLE_SCHEDULER:
      return "scheduler";
    case v1::ROLE_IDENTIFICATION:
      return "identification";
    case v1::ROLE_ARCHIVE:
      return "archive";
    case v1::ROLE_DASHBOARD:
      return "dashboard";
    case v1::ROLE_OPERATOR:
      return "operator";
  }
  return "unknown";
}

Id idl_hash() { return *id_from_hex(v1::kIdlHash); }

Result<HealthReporter> HealthReporter::create(bus::Bus& bus, const Clock& clock, v1::ServiceRole role,
                                              const CommonOptions& options,
                                              std::shared_ptr<bus::Notifier> notifier) {
  auto writer = bus::TypedWriter<v1::ServiceHealth>::create(bus, topics::kServiceHealth);
  if (!writer) return writer.error();
  v1::ServiceHealth health;
  health.role(role);
  health.name(options.rig);
  health.instance_id(id_of(fmt::format("service/{}/{}", role_name(role), options.rig)));
  health.host(host_name());
  health.idl_hash(idl_hash());
  health.software_version(kVersion);
  health.vendor(options.dds);
  health.started_ns(clock.utc_ns());
  health.process_id(static_cast<std::uint64_t>(getpid()));
  health.state("starting");
  auto configuration = bus::TypedWriter<v1::ServiceConfiguration>::create(bus, topics::kServiceConfiguration);
  if (!configuration) return configuration.error();
  if (auto written = configuration->write(configuration_of(health, options)); !written)
    return written.error();
  auto others = bus::TypedReader<v1::ServiceHealth>::create(bus, topics::kServiceHealth, nullptr);
  if (!others) return others.error();
  auto clock_answer = ClockAnswer::create(bus, clock, health.instance_id(), std::move(notifier));
  if (!clock_answer) return clock_answer.error();
  return HealthReporter(std::move(*writer), std::move(*configuration), std::move(*others),
                        std::move(*clock_answer), clock, health);
}

HealthReporter::HealthReporter(bus::TypedWriter<v1::ServiceHealth> writer,
                               bus::TypedWriter<v1::ServiceConfiguration> configuration,
                               bus::TypedReader<v1::ServiceHealth> others, ClockAnswer clock_answer,
                               const Clock& clock, v1::ServiceHealth health)
    : writer_(std::move(writer)),
      configuration_(std::move(configuration)),
      others_(std::move(others)),
      clock_answer_(std::move(clock_answer)),
      clock_(&clock),
      health_(std::move(health)),
      begun_(clock.now()) {}

HealthReporter::HealthReporter(HealthReporter&& other) noexcept
    : writer_(std::exchange(other.writer_, std::nullopt)),
      configuration_(std::move(other.configuration_)),
      others_(std::move(other.others_)),
      clock_answer_(std::move(other.clock_answer_)),
      clock_(other.clock_),
      health_(std::move(other.health_)),
      other_(std::move(other.other_)),
      begun_(other.begun_),
      due_(other.due_),
      has_changed_(other.has_changed_) {}

HealthReporter::~HealthReporter() {
  if (!writer_) return;
  health_.is_ready(false);
  health_.is_leaving(true);
  health_.state("ended");
  publish();
  tell_service_manager_of_the_end();
}

void HealthReporter::set_state(bool is_ready, const std::string& state) {
  if (health_.is_ready() == is_ready && health_.state() == state) return;
  health_.is_ready(is_ready);
  health_.state(state);
  has_changed_ = true;
}

void HealthReporter::set_warnings(std::vector<std::string> warnings) {
  if (warnings.size() > kMostWarnings) warnings.resize(kMostWarnings);
  if (health_.warnings() == warnings) return;
  health_.warnings(std::move(warnings));
  has_changed_ = true;
}

void HealthReporter::set_load(double lag_s, std::uint32_t queue_depth, std::uint64_t dropped) {
  health_.lag_s(lag_s);
  health_.queue_depth(queue_depth);
  health_.dropped(dropped);
}

void HealthReporter::hear_others() {
  for (auto& received : drain(others_)) {
    const v1::ServiceHealth& heard = received.value;
    const bool is_own = heard.process_id() == health_.process_id() && heard.host() == health_.host() &&
                        heard.started_ns() == health_.started_ns();
    if (heard.instance_id() != health_.instance_id() || is_own) continue;
    const bool is_same =
        other_ && other_->health.process_id() == heard.process_id() && other_->health.host() == heard.host();
    if (heard.is_leaving()) {
      if (is_same) other_.reset();
      continue;
    }
    other_ = Other{heard, is_same ? other_->reports + 1 : 1, clock_->now()};
  }
  if (other_ && clock_->now() - other_->heard > kOtherForgotten) other_.reset();
}

bool HealthReporter::is_older_than_other() const {
  const auto order = [](const v1::ServiceHealth& health) {
    return std::tuple(health.started_ns(), health.host(), health.process_id());
  };
  return order(health_) < order(other_->health);
}

Result<void> HealthReporter::check_alone() const {
  if (!other_ || other_->reports < kReportsOfAnother) return {};
  if (is_older_than_other() || clock_->now() - begun_ > kNew) return {};
  return fail(ErrorCode::kAlreadyExists, other());
}

std::string HealthReporter::other() const {
  if (!other_ || other_->reports < (is_older_than_other() ? kReportsOfSecond : kReportsOfAnother)) return {};
  return fmt::format("another {} '{}' is on the bus: process {} on {}; end one of them",
                     role_name(health_.role()), health_.name(), other_->health.process_id(),
                     other_->health.host());
}

Clock::TimePoint HealthReporter::publish_if_due() {
  clock_answer_.answer();
  hear_others();
  if (has_changed_ || clock_->now() >= due_) publish();
  return due_;
}

void HealthReporter::publish() {
  v1::ServiceHealth report = health_;
  if (const std::string doubled = other(); !doubled.empty()) {
    report.is_ready(false);
    report.state(doubled);
  }
  log_refused_packets(*clock_);
  // A report that cannot be sent is followed by the next one half a second later.
  (void)writer_->write(report);
  tell_service_manager((report.is_ready() ? "" : "not ready: ") + report.state());
  has_changed_ = false;
  due_ = clock_->now() + kPeriod;
}

Result<void> listen_for_others(HealthReporter& health, const CommonOptions& options, const Clock& clock,
                               bus::Notifier& notifier, const StopSignal& stop) {
  if (options.interface.empty()) return {};
  health.set_state(false, "starting: listening for another of its kind on the network");
  const auto end = clock.now() + kListening;
  while (clock.now() < end && !stop.is_requested()) {
    const auto due = health.publish_if_due();
    TONUS_TRY(health.check_alone());
    (void)notifier.wait_until(std::min({due, end, clock.now() + kPeriod}));
  }
  return {};
}

std::string difference(const v1::ServiceHealth& health) {
  const char* role = role_name(health.role());
  if (health.idl_hash() != idl_hash()) {
    return fmt::format(
        "{} on {} speaks contract {} (version {}), this program {} (version {}); install one version "
        "everywhere",
        role, health.host(), to_hex(health.idl_hash()), health.software_version(), v1::kIdlHash, kVersion);
  }
  if (health.software_version() != kVersion) {
    return fmt::format("{} on {} has version {}, this program {}; install one version everywhere", role,
                       health.host(), health.software_version(), kVersion);
  }
  return {};
}

Result<Roster> Roster::create(bus::Bus& bus, const Clock& clock, std::shared_ptr<bus::Notifier> notifier) {
  auto reader = bus::TypedReader<v1::ServiceHealth>::create(bus, topics::kServiceHealth, notifier);
  if (!reader) return reader.error();
  return Roster(std::move(*reader), clock);
}

Roster::Roster(bus::TypedReader<v1::ServiceHealth> reader, const Clock& clock)
    : reader_(std::move(reader)), clock_(&clock) {}

void Roster::update() {
  for (auto& received : drain(reader_)) {
    const Id id = received.value.instance_id();
    if (received.value.is_leaving()) {
      const auto known = entries_.find(id);
      // The last word of a service that its successor has replaced says nothing of the successor.
      if (known != entries_.end() && known->second.health.process_id() == received.value.process_id()) {
        entries_.erase(known);
      }
      continue;
    }
    Entry& entry = entries_[id];
    entry = {std::move(received.value), clock_->now(), entry.reports + 1};
  }
  std::erase_if(entries_,
                [this](const auto& entry) { return clock_->now() - entry.second.heard > kSilence; });
}

std::vector<v1::ServiceHealth> Roster::present() const {
  std::vector<v1::ServiceHealth> all;
  for (const auto& [id, entry] : entries_) all.push_back(entry.health);
  return all;
}

std::optional<v1::ServiceHealth> Roster::find(v1::ServiceRole role) const {
  for (const auto& [id, entry] : entries_) {
    if (entry.health.role() == role) return entry.health;
  }
  return std::nullopt;
}

std::uint64_t Roster::reports(v1::ServiceRole role) const {
  for (const auto& [id, entry] : entries_) {
    if (entry.health.role() == role) return entry.reports;
  }
  return 0;
}

std::string Roster::missing(const std::vector<v1::ServiceRole>& roles, bool must_be_ready) const {
  std::string text;
  const auto add = [&text](const std::string& item) { text += (text.empty() ? "" : "; ") + item; };
  const std::string unreadable =
      reader_.status().malformed > 0
          ? " (a service reports here that cannot be read: it is of another version)"
          : "";
  for (const auto role : roles) {
    const auto health = find(role);
    if (!health) {
      add(fmt::format("{} is not there{}", role_name(role), unreadable));
    } else if (const std::string differs = difference(*health); !differs.empty()) {
      add(differs);
    } else if (must_be_ready && !health->is_ready()) {
      add(fmt::format("{} is not ready: {}", role_name(role), health->state()));
    }
  }
  return text;
}

}  // namespace tonus::runtime
