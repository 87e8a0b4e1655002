#include <benchmark/benchmark.h>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/recursive_least_squares.hpp"
#include "analysis_service/impedance/streaming_identifier.hpp"
#include "tests/support/impedance/linear_rig.hpp"

namespace tonus::impedance::test {
namespace {

/// The streaming path: raw counts and volts to SI, state-variable filter of four signals, update of 7
/// regressors and 2 outputs. Only samples inside the fitted window are counted, as only they take the whole
/// path.
void stream_from_raw_samples(benchmark::State& state) {
  const SimulatedRig rig;
  const RigGeometry geometry = geometry_of(rig);
  const ShoulderPose shoulder = shoulder_of(rig);
  const RawTrial raw = simulate_raw(typical_subject(), rig, 0.4, 1);
  Preparation preparation;
  preparation.sample_period = rig.sample_period;
  auto live = StreamingIdentifier::create(Options{}, preparation).value();
  const auto onset = static_cast<std::size_t>(raw.onset);
  constexpr std::size_t kWindow = 200;
  std::int64_t samples = 0;
  for (auto _ : state) {
    live.begin_trial(1);
    for (std::size_t k = 0; k < onset; ++k) live.push_rest(convert(geometry, shoulder, raw.samples[k]));
    live.mark_onset();
    for (std::size_t k = onset; k < onset + kWindow; ++k)
      live.push(convert(geometry, shoulder, raw.samples[k]));
    benchmark::ClobberMemory();
    samples += kWindow;  // The 100 samples of rest, converted and filtered too, come on top.
  }
  state.SetItemsProcessed(samples);
}
BENCHMARK(stream_from_raw_samples);

/// The update alone.
void update_least_squares(benchmark::State& state) {
  RecursiveLeastSquares<7, 2> rls;
  Eigen::Vector<double, 7> phi(1.0, -0.5, 0.08, 0.03, 0.005, -0.002, 1.0);
  const Eigen::Vector2d f(1.0, -2.0);
  for (auto _ : state) {
    phi[0] = -phi[0];
    phi[3] += 1e-6;
    rls.update(phi, f);
    benchmark::DoNotOptimize(rls);
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(update_least_squares);

/// One condition of 16 trials from prepared samples: filter, fit, intervals, diagnosis, trace.
void identify_condition(benchmark::State& state) {
  SimulatedRig rig;
  rig.is_command_recorded = true;
  const auto trials = simulate(typical_subject(), rig, directions(), 1);
  Options options;
  options.method = kPerturbationMethods[state.range(0)];
  options.has_trace = state.range(1) != 0;
  for (auto _ : state) benchmark::DoNotOptimize(identify(trials, options));
  state.SetLabel(std::string(name_of(options.method)) + (options.has_trace ? ", with trace" : ""));
}
BENCHMARK(identify_condition)->ArgsProduct({{0, 1, 2, 3}, {0, 1}})->Unit(benchmark::kMillisecond);

/// What a dashboard asks for while samples arrive.
void estimate_live(benchmark::State& state) {
  const SimulatedRig rig;
  Preparation preparation;
  preparation.sample_period = rig.sample_period;
  auto live = StreamingIdentifier::create(Options{}, preparation).value();
  std::uint32_t number = 0;
  for (const double direction : directions()) {
    const RawTrial raw = simulate_raw(typical_subject(), rig, direction, number + 1);
    const auto samples = convert_all(rig, raw.samples);
    live.begin_trial(++number);
    for (Eigen::Index k = 0; k < raw.onset; ++k) live.push_rest(samples[static_cast<std::size_t>(k)]);
    live.mark_onset();
    for (auto k = static_cast<std::size_t>(raw.onset); k < samples.size(); ++k) live.push(samples[k]);
    if (!live.end_trial()) state.SkipWithError("a trial was refused");
  }
  for (auto _ : state) benchmark::DoNotOptimize(live.estimate());
}
BENCHMARK(estimate_live)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tonus::impedance::test
