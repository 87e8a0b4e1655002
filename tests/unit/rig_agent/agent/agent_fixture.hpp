#pragma once

#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "idl/topics.hpp"
#include "rig_agent/agent/agent.hpp"
#include "rig_agent/agent/rig.hpp"
#include "services/bus/memory/memory_fabric.hpp"
#include "services/runtime/drain.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::rig {

inline const Id kSession = id_of("session");

/// A rig agent with the simulated driver at full speed, and the other services' ends of an in-memory bus.
class AgentTest : public ::testing::Test {
 protected:
  void SetUp() override {
    bus::BusOptions options;
    options.vendor = bus::Vendor::kMemory;
    options.fabric = std::make_shared<bus::MemoryFabric>();
    bus_ = std::move(*bus::create_bus(options));
    samples_.emplace(*bus::TypedReader<v1::SampleBlock>::create(*bus_, topics::kRigSamples, nullptr));
    outcomes_.emplace(*bus::TypedReader<v1::TrialOutcome>::create(*bus_, topics::kTrialOutcome, nullptr));
    commands_.emplace(*bus::TypedWriter<v1::TrialCommand>::create(*bus_, topics::kTrialCommand));
    rig_commands_.emplace(*bus::TypedWriter<v1::RigCommand>::create(*bus_, topics::kRigCommand));
    rig_replies_.emplace(*bus::TypedReader<v1::RigReply>::create(*bus_, topics::kRigReply, nullptr));
    resends_.emplace(*bus::TypedWriter<v1::ArchiveResend>::create(*bus_, topics::kArchiveResend));
    states_.emplace(*bus::TypedReader<v1::RigState>::create(*bus_, topics::kRigState, nullptr));
    start_armed(1000);
  }

  void start_agent(std::uint64_t epoch, bool is_paced = false) {
    stop_agent();
    epoch_ = epoch;
    RigOptions rig_options;
    rig_options.speed = is_paced ? "real" : "max";
    rig_options.seed = 1;
    rig_options.profile = profile_;
    auto rig = Rig::create(rig_options, "rig");
    ASSERT_TRUE(rig) << rig.error().message;
    rig_.emplace(std::move(*rig));
    spool_.emplace(*Spool::open({.folder = folder_ / "spool", .max_bytes = spool_bytes_}));
    log_.emplace(*TrialLog::open(folder_ / "trials.log"));
    Publisher::Options publishing{
        .rig = rig_->names().id, .epoch = epoch, .auxiliary_values = rig_->loop().auxiliary_values()};
    publisher_.emplace(publishing, *spool_, std::move(*bus_->create_writer(topics::kRigSamples.spec)),
                       std::move(*bus_->create_writer(topics::kRigAuxiliary.spec)), clock_);
    latch_.emplace(*HoldLatch::open(folder_ / "hold"));
    lease_.emplace(rig_->names().id, epoch);
    AgentOptions options{.names = rig_->names(), .epoch = epoch, .is_paced = is_paced};
    options.resumes_unattended = resumes_unattended_;
    agent_.emplace(options,
                   AgentParts{rig_->loop(), rig_->driver(), nullptr, *publisher_, *spool_, *log_, *latch_,
                              *lease_, stops_},
                   std::move(*AgentEndpoints::create(*bus_, nullptr)), clock_);
    agent_->start(describe(rig_->names(), rig_->driver().geometry()));
  }

  /// As if armed long enough ago, with a scheduler that is always there.
  void arm() {
    lease_->arm(kSession, clock_.now() - std::chrono::seconds(2));
    v1::RigLease lease;
    lease.rig_id(rig_->names().id);
    lease.session_id(kSession);
    lease.epoch(epoch_);
    lease_->hear(lease, clock_.now());
  }

  /// Starts an agent that is armed for the session.
  void start_armed(std::uint64_t epoch, bool is_paced = false) {
    start_agent(epoch, is_paced);
    arm();
  }

  v1::RigReply ask(v1::RigCommand command) {
    command.rig_id(rig_->names().id);
    command.request_id(random_id());
    EXPECT_TRUE(rig_commands_->write(command));
    for (int i = 0; i < 1000; ++i) {
      agent_->step();
      for (const auto& received : runtime::drain(*rig_replies_)) {
        if (received.value.request_id() == command.request_id()) return received.value;
      }
    }
    ADD_FAILURE() << "the request is not answered";
    return {};
  }

  v1::RigReply ask(v1::RigRequest request) {
    v1::RigCommand command;
    command.request(request);
    command.session_id(kSession);
    command.epoch(epoch_);
    command.hold_number(latch_->number());
    return ask(command);
  }

  v1::RigState state() {
    for (auto& received : runtime::drain(*states_)) state_ = received.value;
    return state_;
  }

  void stop_agent() {
    agent_.reset();
    latch_.reset();
    lease_.reset();
    publisher_.reset();
    log_.reset();
    spool_.reset();
    rig_.reset();
  }

  v1::TrialCommand command(std::uint32_t attempt) const {
    v1::TrialCommand c;
    c.trial_id(trial_id(kSession, attempt));
    auto& p = c.program();
    p.session_id(kSession);
    p.rig_id(rig_->names().id);
    p.attempt(attempt);
    p.posture("reference");
    p.posture_m({0.0, 0.38});
    const Eigen::Vector2d origin = rig_->names().home - Eigen::Vector2d(0.0, 0.38);
    p.shoulder_origin_m({origin.x(), origin.y()});
    p.direction_deg(45.0);
    p.amplitude_m(0.005);
    p.rise_time_s(0.2);
    p.hold_s(1.5);
    p.wait_s(3.0);
    p.bias_ramp_s(2.0);
    p.bias_hold_s(1.0);
    p.bias_threshold_N(0.1);
    p.recording_index(-1);
    p.recording_event(-1);
    return c;
  }

  /// Steps the agent until a trial's outcome comes; fails after far more steps than a trial takes.
  std::optional<v1::TrialOutcome> run_to_outcome() {
    for (int i = 0; i < 1000; ++i) {
      agent_->step();
      collect_blocks();
      for (auto& received : runtime::drain(*outcomes_)) return received.value;
    }
    return std::nullopt;
  }

  void collect_blocks() {
    for (auto& received : runtime::drain(*samples_)) blocks_.push_back(std::move(received.value));
  }

  testing::TemporaryFolder folder_;
  std::string profile_;  // of the next agent; empty: the built-in one
  std::uint64_t spool_bytes_ = 4ULL << 30;
  SystemClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::optional<bus::TypedReader<v1::SampleBlock>> samples_;
  std::optional<bus::TypedReader<v1::TrialOutcome>> outcomes_;
  std::optional<bus::TypedReader<v1::RigReply>> rig_replies_;
  std::optional<bus::TypedWriter<v1::TrialCommand>> commands_;
  std::optional<bus::TypedWriter<v1::RigCommand>> rig_commands_;
  std::optional<bus::TypedWriter<v1::ArchiveResend>> resends_;
  std::optional<Rig> rig_;
  std::optional<Spool> spool_;
  std::optional<TrialLog> log_;
  std::optional<Publisher> publisher_;
  std::optional<HoldLatch> latch_;
  std::optional<Lease> lease_;
  StopRequests stops_;
  std::optional<Agent> agent_;
  std::optional<bus::TypedReader<v1::RigState>> states_;
  v1::RigState state_;
  std::uint64_t epoch_ = 0;
  bool resumes_unattended_ = false;
  std::vector<v1::SampleBlock> blocks_;
};

}  // namespace tonus::rig
