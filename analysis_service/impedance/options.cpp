#include "analysis_service/impedance/options.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <spdlog/fmt/fmt.h>
#include <string>

namespace tonus::impedance {
namespace {

template <typename T>
Result<T> named(std::span<const T> all, std::string_view name, const char* what) {
  std::string allowed;
  for (const T& one : all) {
    if (name_of(one) == name) return one;
    allowed += (allowed.empty() ? "" : ", ") + std::string(name_of(one));
  }
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: '{}' is not allowed; expected one of {}", what, name, allowed));
}

}  // namespace

std::string_view name_of(Method method) {
  switch (method) {
    case Method::kLowpass:
      return "lowpass";
    case Method::kOptimal:
      return "optimal";
    case Method::kStateVariable:
      return "state_variable";
    case Method::kRefined:
      return "refined";
    case Method::kSpectral:
      return "spectral";
  }
  return "unknown";
}

std::string_view name_of(Model model) {
  switch (model) {
    case Model::kLinear:
      return "linear";
    case Model::kNoDamping:
      return "no_damping";
    case Model::kCoriolis:
      return "coriolis";
    case Model::kSquaredVelocity:
      return "squared_velocity";
    case Model::kSignedSquaredVelocity:
      return "signed_squared_velocity";
    case Model::kFriction:
      return "friction";
    case Model::kCubic:
      return "cubic";
    case Model::kReflex:
      return "reflex";
    case Model::kAutomatic:
      return "auto";
  }
  return "unknown";
}

Result<Method> method_named(std::string_view name) { return named<Method>(kEveryMethod, name, "method"); }

Result<Model> model_named(std::string_view name) {
  std::vector<Model> all(std::begin(kModels), std::end(kModels));
  all.insert(all.end(), std::next(std::begin(kRecordModels)), std::end(kRecordModels));  // linear once
  return named<Model>(all, name, "model");
}

bool is_record_model(Model model) {
  return std::ranges::find(kRecordModels, model) != std::end(kRecordModels);
}
bool is_published_model(Model model) { return std::ranges::find(kModels, model) != std::end(kModels); }

bool suits(Method method, bool is_record) {
  if (is_record) return std::ranges::find(kRecordMethods, method) != std::end(kRecordMethods);
  return std::ranges::find(kPerturbationMethods, method) != std::end(kPerturbationMethods);
}

bool has_model(Method method, Model model) { return method != Method::kRefined || model == Model::kLinear; }

Result<Options> with_method(Options options, std::string_view name) {
  if (name == kAutomatic) return options;
  auto method = method_named(name);
  if (!method) return fail(method.error().code, method.error().message + ", auto or all");
  options.method = *method;
  if (*method != Method::kRefined) options.record_method = *method;
  return options;
}

std::vector<Options> by_every_method(const Options& options) {
  std::vector<Options> all;
  for (const Method method : kEveryMethod) {
    all.push_back(options);
    all.back().method = all.back().record_method = method;
  }
  return all;
}

Result<void> validate(const Options& options, double sample_period) {
  const auto refuse = [](const char* what, double value, const std::string& allowed) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} is not allowed; expected {}", what, value, allowed));
  };
  if (!(sample_period > 0.0)) return refuse("sample period", sample_period, "more than 0 s");
  const double nyquist = 0.5 / sample_period;
  const auto below_nyquist = fmt::format("more than 0 and less than {} Hz", nyquist);
  if (!(options.window >= 10.0 * sample_period) || !(options.window <= 3600.0)) {
    return refuse("window", options.window, fmt::format("{} to 3600 s", 10.0 * sample_period));
  }
  if (!(options.cutoff > 0.0) || !(options.cutoff < nyquist))
    return refuse("cutoff", options.cutoff, below_nyquist);
  if (options.natural_frequency &&
      (!(*options.natural_frequency > 0.0) || !(*options.natural_frequency < nyquist))) {
    return refuse("natural frequency", *options.natural_frequency, below_nyquist);
  }
  if (!(options.damping_ratio > 0.0) || !(options.damping_ratio <= 1.0)) {
    return refuse("damping ratio", options.damping_ratio, "more than 0, at most 1");
  }
  if (!(options.block >= 10.0 * sample_period) || !(options.block <= 3600.0)) {
    return refuse("block", options.block, fmt::format("{} to 3600 s", 10.0 * sample_period));
  }
  if (!(options.rank_margin > 0.0) || !(options.rank_margin < 1.0)) {
    return refuse("rank margin", options.rank_margin, "between 0 and 1");
  }
  if (!(options.settling_share > 0.0)) return refuse("settling share", options.settling_share, "more than 0");
  return {};
}

}  // namespace tonus::impedance
