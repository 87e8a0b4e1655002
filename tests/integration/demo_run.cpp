#include "tests/integration/demo_run.hpp"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "services/simulation/profile.hpp"
#include "services/simulation/true_impedance.hpp"
#include "services/store/open_store.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kLimit{240};

struct NamedPosture {
  const char* name;
  Eigen::Vector2d position;
};

/// reference/tables.toml, [positions_m]: the paper's five test positions.
const NamedPosture kPostures[] = {{"reference", {0.0, 0.38}},
                                  {"distal", {0.0, 0.52}},
                                  {"proximal", {0.0, 0.24}},
                                  {"right", {0.295, 0.38}},
                                  {"left", {-0.295, 0.38}}};

void expect_matrix(const nlohmann::json& estimate, const Eigen::Matrix2d& truth, double share,
                   const std::string& what) {
  const double largest = truth.cwiseAbs().maxCoeff();
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      const double value = estimate.at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(column));
      EXPECT_NEAR(value, truth(row, column), share * largest)
          << what << "(" << row << "," << column << "), largest element " << largest;
    }
  }
}

}  // namespace

DemoRun::DemoRun(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "demo");
  for (const std::string& word :
       {std::string("--domain"), std::to_string(own_domain()), std::string("--data"),
        (folder_ / "data").string(), std::string("--json"), (folder_ / "results.json").string()}) {
    arguments.push_back(word);
  }
  process_ = std::make_unique<Process>(program("tonus"), arguments, folder_ / "output");
}

int DemoRun::finish() { return process_->wait(kLimit); }

std::string DemoRun::everything_printed() const {
  std::string text = process_->output();
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "data" / "logs", none)) {
    std::ifstream file(entry.path());
    std::ostringstream log;
    log << file.rdbuf();
    text += "--- " + entry.path().filename().string() + "\n" + log.str();
  }
  return text;
}

nlohmann::json DemoRun::results() const {
  std::ifstream file(folder_ / "results.json");
  return nlohmann::json::parse(file, nullptr, false);
}

store::Session DemoRun::archived() const {
  auto store = store::open_store_for_reading((folder_ / "data" / "archive.sqlite").string());
  EXPECT_TRUE(store) << store.error().message;
  if (!store) return {};
  const auto record = store::find_session(**store, "last");
  EXPECT_TRUE(record) << record.error().message;
  if (!record) return {};
  auto session = store::read_session(**store, record->session);
  EXPECT_TRUE(session) << session.error().message;
  return session ? *session : store::Session{};
}

void expect_truth_within(const nlohmann::json& results, double share) {
  const auto profile = simulation::load_profile(source_file("deploy/profiles/default.toml"));
  ASSERT_TRUE(profile) << profile.error().message;
  const auto& conditions = results.at("conditions");
  ASSERT_EQ(conditions.size(), std::size(kPostures));
  for (const auto& posture : kPostures) {
    const auto found = std::find_if(conditions.begin(), conditions.end(),
                                    [&](const auto& c) { return c.at("posture") == posture.name; });
    ASSERT_NE(found, conditions.end()) << posture.name;
    EXPECT_EQ(found->at("status"), "ok") << posture.name << " " << found->at("reasons");
    EXPECT_EQ(found->at("trials_used"), 16) << posture.name;
    const auto truth = simulation::true_impedance(profile->subject, posture.position);
    const std::string name = posture.name;
    expect_matrix(found->at("M_kg"), truth.mass, share, name + " M");
    expect_matrix(found->at("B_Ns_per_m"), truth.damping, share, name + " B");
    expect_matrix(found->at("K_N_per_m"), truth.stiffness, share, name + " K");
  }
}

}  // namespace tonus::testing
