#include "analysis_service/service/rigs_service.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <map>

#include "services/core/name.hpp"
#include "tests/unit/analysis_service/service/peers.hpp"

namespace tonus::identification {
namespace {

/// One rig's session: trials of an arm that other rigs do not have, with numbers that all of them have.
struct Session {
  std::string rig;
  Id id{};
  std::vector<MeasuredTrial> trials;

  Session(const std::string& name, double amplitude) : rig(name), id(id_of("session of " + name)) {
    for (std::uint32_t i = 0; i < 16; ++i) {
      testing::Recipe recipe;
      recipe.attempt = i + 1;
      recipe.direction_deg = 45.0 * (i % 8);
      recipe.set = i < 8 ? 1 : 2;
      recipe.first_sequence = 1000 + 1000 * i;
      recipe.amplitude = amplitude;
      recipe.added_force = [amplitude](double t, Phase) {
        return Eigen::Vector2d(amplitude * std::sin(40.0 * t), -amplitude * std::cos(30.0 * t));
      };
      trials.push_back(testing::as_of(testing::made_up_trial(recipe), name, id));
    }
  }
};

/// What came of one trial, without the times at which it was sent.
struct Answer {
  v1::TrialVerdict verdict;
  v1::Estimate estimate;
};

/// The services of `names` in one process, and the answers to the sessions, whose trials come side by side.
class Lab {
 public:
  explicit Lab(const std::vector<std::string>& names) : ended_(std::make_shared<bus::Notifier>()) {
    std::vector<RigParts> parts;
    for (const std::string& name : names) {
      buses_.push_back(open(fabric_, "identification"));
      ServiceSettings settings;
      settings.rig = rig_id(name);
      settings.served = "several";
      parts.push_back(RigParts::create(*buses_.back(), clock_, common(name), settings).value());
    }
    service_ = std::make_unique<RigsService>(std::move(parts), clock_, ended_);
  }

  void introduce(const Session& session) {
    peers_[session.rig] = std::make_unique<Peers>(fabric_, session.rig, session.id);
    peers_[session.rig]->introduce();
  }

  /// Waits until the health of the rig's identification is as `is_so` has it.
  template <typename Condition>
  [[nodiscard]] bool says(const std::string& rig, Condition is_so) {
    return eventually([&] {
      const auto healths = runtime::drain(peers_.at(rig)->healths);
      return std::any_of(healths.begin(), healths.end(), [&](const auto& received) {
        return received.value.role() == v1::ROLE_IDENTIFICATION && received.value.name() == rig &&
               is_so(received.value);
      });
    });
  }
  [[nodiscard]] bool is_ready(const std::string& rig) {
    return says(rig, [](const v1::ServiceHealth& health) { return health.is_ready(); });
  }

  /// Sends the trial's rows and reports it.
  void measure(const Session& session, std::size_t i) {
    const MeasuredTrial& trial = session.trials[i];
    Peers& peers = *peers_.at(session.rig);
    peers.command(trial);
    peers.send_rows(trial, trial.report.range);
    peers.report(trial);
  }

  /// The rig's verdict on the trial and the first estimate that has it.
  Answer answer(const Session& session, std::size_t i) {
    Answer answer;
    bool is_judged = false;
    bool is_estimated = false;
    Peers& peers = *peers_.at(session.rig);
    EXPECT_TRUE(eventually([&] {
      for (const auto& received : runtime::drain(peers.verdicts)) {
        if (received.value.trial_id() != session.trials[i].report.plan.trial) continue;
        is_judged = true;
        answer.verdict = received.value;
      }
      for (const auto& received : runtime::drain(peers.estimates)) {
        if (received.value.session_id() != session.id || received.value.trials_used() != i + 1) continue;
        is_estimated = true;
        answer.estimate = received.value;
      }
      return is_judged && is_estimated;
    })) << session.rig
        << ", trial " << i + 1;
    return answer;
  }

 private:
  std::shared_ptr<bus::MemoryFabric> fabric_ = std::make_shared<bus::MemoryFabric>();
  SystemClock clock_;
  std::shared_ptr<bus::Notifier> ended_;
  std::vector<std::unique_ptr<bus::Bus>> buses_;
  std::map<std::string, std::unique_ptr<Peers>> peers_;
  std::unique_ptr<RigsService> service_;
};

using Answers = std::map<std::string, std::vector<Answer>>;

Answers measured(const std::vector<Session>& sessions) {
  std::vector<std::string> names;
  for (const Session& session : sessions) names.push_back(session.rig);
  Lab lab(names);
  for (const Session& session : sessions) lab.introduce(session);
  for (const Session& session : sessions) EXPECT_TRUE(lab.is_ready(session.rig)) << session.rig;
  Answers answers;
  for (std::size_t i = 0; i < sessions.front().trials.size(); ++i) {
    for (const Session& session : sessions) lab.measure(session, i);
    for (const Session& session : sessions) answers[session.rig].push_back(lab.answer(session, i));
  }
  return answers;
}

void expect_the_same(const std::vector<Answer>& alone, const std::vector<Answer>& together) {
  ASSERT_EQ(alone.size(), together.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_EQ(bus::encode(alone[i].verdict).value(), bus::encode(together[i].verdict).value()) << i;
    EXPECT_EQ(bus::encode(alone[i].estimate).value(), bus::encode(together[i].estimate).value()) << i;
  }
}

TEST(RigsService, GivesTwoRigsWhoseSessionsInterleaveWhatEachGetsAlone) {
  const Session left("left", 0.005);
  const Session right("right", 0.006);
  const auto left_alone = measured({left});
  const auto right_alone = measured({right});

  auto together = measured({left, right});

  expect_the_same(left_alone.at("left"), together["left"]);
  expect_the_same(right_alone.at("right"), together["right"]);
  const auto& first = together["left"].back().estimate.stiffness_N_per_m().value();
  const auto& second = together["right"].back().estimate.stiffness_N_per_m().value();
  EXPECT_NE(first, second);  // they were not the same session
}

TEST(RigsService, ReportsEachRigsHealthByItsNameAndSaysThatItServesSeveral) {
  Lab lab({"left", "right"});
  const Session left("left", 0.005);
  const Session right("right", 0.005);
  lab.introduce(left);
  EXPECT_TRUE(lab.says("left", [](const v1::ServiceHealth& health) {
    return health.is_ready() && health.state() == "ready; one process serves several";
  }));
  lab.introduce(right);
  EXPECT_TRUE(lab.is_ready("right"));
}

TEST(RigsService, IsNotReadyForARigWhoseDescriptionIsNotThereWhileAnotherIsServed) {
  Lab lab({"left", "right"});
  const Session left("left", 0.005);
  lab.introduce(left);
  ASSERT_TRUE(lab.is_ready("left"));
  EXPECT_TRUE(lab.says("left", [](const v1::ServiceHealth& health) { return health.is_ready(); }));
  lab.measure(left, 0);
  EXPECT_TRUE(lab.answer(left, 0).verdict.is_valid());
}

}  // namespace
}  // namespace tonus::identification
