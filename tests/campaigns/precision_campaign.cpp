// precision-campaign: conditions that end by their precision, simulated with drawn subjects.

#include <CLI/CLI.hpp>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "analysis_service/certify/precision_led.hpp"
#include "analysis_service/impedance/parameters.hpp"
#include "services/core/parallel.hpp"

namespace tonus::campaigns {
namespace {

using certify::LedCondition;
using certify::LedDesign;

constexpr std::size_t kPublishedTrials = 16;

/// Of conditions, in the order of the table.
const std::vector<std::string> kKinds{"published", "stopping", "rise", "amplitude", "both", "raised"};

struct Campaign {
  std::uint64_t seed = 1;
  std::size_t conditions = 300;
  std::vector<std::string> settings{"white", "encoder", "living"};
  std::vector<std::string> kinds = kKinds;
  double entropy = 1.0;
  int least = 6;
  int most = 64;
  std::size_t looks = protocol::kLooksInARow;
};

/// What one kind of condition needs.
struct Tally {
  std::string name;
  std::vector<double> trials;      // by condition
  std::array<double, 4> inside{};  // M, B, K, X0: elements whose truth lies in the interval
  std::array<double, 4> elements{};
  std::vector<double> stiffness;  // by condition: share of K's elements inside
  double entropy = 0.0;
  double least_entropy = 1e9;
  std::size_t reached = 0;
  std::size_t suspect = 0;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Standard error of the mean.
double error_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  return std::sqrt(std::max(0.0, squares / count - sum * sum / count / count) / count);
}

void count_inside(const certify::Truth& truth, const impedance::Estimate& estimate, Tally& tally) {
  if (estimate.status == impedance::Status::kUndetermined) return;
  Eigen::VectorXd expected(14);
  expected << truth.arm.M.reshaped(), truth.arm.B.reshaped(), truth.arm.K.reshaped(), 0.0, 0.0;
  const Eigen::VectorXd low = impedance::flatten(estimate.low);
  const Eigen::VectorXd high = impedance::flatten(estimate.high);
  double inside = 0.0;
  for (Eigen::Index i = 0; i < 14; ++i) {
    const auto matrix = static_cast<std::size_t>(i / 4);
    const double is_inside = low[i] <= expected[i] && expected[i] <= high[i] ? 1.0 : 0.0;
    tally.inside[matrix] += is_inside;
    tally.elements[matrix] += 1.0;
    if (matrix == 2) inside += 0.25 * is_inside;
  }
  tally.stiffness.push_back(inside);
}

certify::Truth truth_of(const Campaign& campaign, std::size_t i) {
  std::mt19937_64 random(campaign.seed * 1'000'003 + i);
  return certify::draw_truth(static_cast<int>(i % 5), random);
}

Tally run(const Campaign& campaign, const LedDesign& led, const std::string& name) {
  std::vector<LedCondition> conditions(campaign.conditions);
  for_each_in_parallel(campaign.conditions, [&](std::size_t i) {
    conditions[i] = simulate_led(truth_of(campaign, i), led, campaign.seed * 7'000'003 + i);
  });
  Tally tally;
  tally.name = name;
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const LedCondition& c = conditions[i];
    tally.trials.push_back(static_cast<double>(c.trials));
    tally.entropy += c.entropy / static_cast<double>(conditions.size());
    tally.least_entropy = std::min(tally.least_entropy, c.least_entropy);
    tally.reached += c.end == protocol::LookEnd::kReached ? 1 : 0;
    tally.suspect += c.look.is_ok ? 0 : 1;
    count_inside(truth_of(campaign, i), c.estimate, tally);
  }
  return tally;
}

/// Half-widths of stiffness by a method after a number of trials.
std::vector<double> widths(const Campaign& campaign, LedDesign led, impedance::Method method, int trials) {
  led.method = method;
  led.rule.trials_least = led.rule.trials_most = trials;
  std::vector<double> all(campaign.conditions);
  for_each_in_parallel(campaign.conditions, [&](std::size_t i) {
    all[i] = simulate_led(truth_of(campaign, i), led, campaign.seed * 7'000'003 + i).look.stiffness;
  });
  return all;
}

void print(const Tally& tally) {
  std::printf("  %-34s%8.0f%10.0f to %-6.0f", tally.name.c_str(), median(tally.trials),
              quantile(tally.trials, 0.1), quantile(tally.trials, 0.9));
  for (std::size_t m = 0; m < 4; ++m)
    std::printf("%7.1f", 100.0 * tally.inside[m] / std::max(1.0, tally.elements[m]));
  std::printf("%7.1f", 100.0 * error_of(tally.stiffness));
  std::printf("%9.2f%7.2f%9zu%9zu\n", tally.entropy, tally.least_entropy, tally.reached, tally.suspect);
  std::fflush(stdout);
}

Tally run_kind(const Campaign& campaign, LedDesign led, const std::string& kind) {
  if (kind == "stopping") return run(campaign, led, "refined, stopping");
  if (kind == "published") {
    led.method = impedance::Method::kStateVariable;
    return run(campaign, led, "state_variable, stopping");
  }
  const bool is_faster = kind == "rise" || kind == "both";
  led.starts_at_limits = kind != "raised";
  if (is_faster) led.rule.rise_least = 0.1;
  if (kind != "rise") led.rule.amplitude_most = 0.007;
  const char* name = kind == "rise"        ? "refined, rise 0.1 s"
                     : kind == "amplitude" ? "refined, 7 mm"
                     : kind == "both"      ? "refined, rise 0.1 s and 7 mm"
                                           : "refined, raised to 7 mm on its way";
  return run(campaign, led, name);
}

void run_setting(const Campaign& campaign, const certify::Setting& setting) {
  LedDesign led;
  led.setting = setting;
  led.rule.entropy = campaign.entropy;
  const double goal = median(widths(campaign, led, impedance::Method::kStateVariable, kPublishedTrials));
  const double refined = median(widths(campaign, led, impedance::Method::kRefined, kPublishedTrials));
  std::printf(
      "%s: after 16 trials a median half-width of stiffness of %.2f %% by state_variable (the goal), "
      "%.2f %% by refined\n",
      setting.name.c_str(), 100.0 * goal, 100.0 * refined);
  std::printf("  %-34s%8s%20s%7s%7s%7s%7s%7s%9s%7s%9s%9s\n", "", "median", "10 to 90 %", "M", "B", "K", "X0",
              "K +-", "bits", "least", "reached", "suspect");
  led.rule.stiffness = goal;
  led.rule.trials_least = campaign.least;
  led.rule.trials_most = campaign.most;
  led.rule.looks_in_a_row = campaign.looks;
  led.rule.amplitude_most = led.design.amplitude;
  led.rule.rise_least = led.design.rise;
  for (const std::string& kind : kKinds) {
    if (std::find(campaign.kinds.begin(), campaign.kinds.end(), kind) != campaign.kinds.end())
      print(run_kind(campaign, led, kind));
  }
}

}  // namespace
}  // namespace tonus::campaigns

int main(int argc, char** argv) {
  using namespace tonus;
  campaigns::Campaign campaign;
  CLI::App app("Simulates conditions that end by their precision: trials, coverage, entropy.",
               "precision-campaign");
  app.add_option("--seed", campaign.seed, "of subjects, noise and directions")->capture_default_str();
  app.add_option("--conditions", campaign.conditions, "of each kind, over five postures")
      ->check(CLI::Range(5, 100000))
      ->capture_default_str();
  app.add_option("--setting", campaign.settings, "white, encoder, living")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--kind", campaign.kinds, "published, stopping, rise, amplitude, both, raised")
      ->delimiter(',')
      ->check(CLI::IsMember(campaigns::kKinds))
      ->capture_default_str();
  app.add_option("--entropy", campaign.entropy, "bits of each direction")
      ->check(CLI::Range(0.0, 3.0))
      ->capture_default_str();
  app.add_option("--least", campaign.least, "trials before the first look")
      ->check(CLI::Range(5, 64))
      ->capture_default_str();
  app.add_option("--most", campaign.most, "trials of a condition")
      ->check(CLI::Range(5, 1024))
      ->capture_default_str();
  app.add_option("--looks", campaign.looks, "in a row that must be narrow enough")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (const auto& setting : certify::settings()) {
    if (std::find(campaign.settings.begin(), campaign.settings.end(), setting.name) !=
        campaign.settings.end())
      campaigns::run_setting(campaign, setting);
  }
  return 0;
}
