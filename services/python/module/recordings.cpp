#include <memory>
#include <nlohmann/json.hpp>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "rig_agent/in_process/measure.hpp"
#include "services/core/json_text.hpp"
#include "services/python/module/arrays.hpp"
#include "services/python/module/bindings.hpp"
#include "services/python/module/identify.hpp"
#include "services/python/module/request.hpp"
#include "services/python/module/unlocked.hpp"
#include "services/recording/dataset.hpp"

namespace tonus::python {
namespace {

namespace py = pybind11;
using identification::OfflineEstimate;
using nlohmann::json;
using Estimates = Result<std::vector<OfflineEstimate>>;
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

json event_json(const recording::PerturbationEvent& event) {
  const auto optional = [](const std::optional<double>& value) {
    return value ? json(*value) : json(nullptr);
  };
  return {{"onset_s", event.onset_s},
          {"duration_s", event.duration_s},
          {"trial", event.trial},
          {"set", event.set},
          {"direction_deg", optional(event.direction_deg)},
          {"amplitude_m", optional(event.amplitude_m)},
          {"rise_time_s", optional(event.rise_time_s)},
          {"bias_N", event.bias_N},
          {"is_valid", event.is_valid},
          {"reason", event.reason},
          {"instruction", event.instruction}};
}

/// What is known of a recording beside its rows.
std::string facts_of(const recording::Recording& record) {
  json events = json::array();
  for (const auto& event : record.events) events.push_back(event_json(event));
  const auto& place = record.posture_position;
  const json facts{{"participant", record.participant.id},
                   {"session", record.session.empty() ? json(nullptr) : json(record.session)},
                   {"task", record.task},
                   {"run", record.run},
                   {"rate", record.sampling_frequency},
                   {"posture", record.posture},
                   {"posture_m", place ? json({(*place)[0], (*place)[1]}) : json(nullptr)},
                   {"displacement_unit", record.displacement_unit},
                   {"force_unit", record.force_unit},
                   {"handle_mass_kg", record.rig.handle_mass},
                   {"is_force_sign_stated", record.is_force_sign_stated},
                   {"events", events}};
  return json_text(facts, -1);
}

std::string identify_recording(const recording::Recording& record, const py::kwargs& settings) {
  const auto request = request_of(settings);
  return results_text(unlocked([&]() -> Estimates {
    TONUS_TRY_ASSIGN(const auto analyses, identification::analyses_of(request));
    for (const auto& options : analyses) {
      TONUS_TRY(impedance::validate(options, 1.0 / record.sampling_frequency));
    }
    return identification::identify_recordings({&record, 1}, analyses);
  }));
}

std::string identify_whole(const recording::Dataset& dataset, std::optional<int> force_sign,
                           const py::kwargs& settings) {
  const auto request = request_of(settings);
  return results_text(unlocked([&]() -> Result<identification::DatasetEstimates> {
    TONUS_TRY_ASSIGN(const auto analyses, identification::analyses_of(request));
    return identification::identify_dataset(dataset, analyses, force_sign);
  }));
}

std::shared_ptr<recording::Recording> read_recording(const recording::Dataset& dataset, std::size_t index,
                                                     std::optional<int> force_sign) {
  if (index >= dataset.runs()) throw py::index_error("the dataset has no such recording");
  return std::make_shared<recording::Recording>(unlocked([&]() -> Result<recording::Recording> {
    TONUS_TRY_ASSIGN(auto record, dataset.read(index));
    if (force_sign) {
      TONUS_TRY(recording::state_force_sign(record, *force_sign));
    }
    return record;
  }));
}

py::dict recording_arrays(const recording::Recording& record) {
  auto signals = [&] {
    const py::gil_scoped_release release;
    return std::make_shared<const Signals>(signals_of(record));
  }();
  return arrays_of(std::move(signals));
}

/// A measured posture of the profile's subject on the simulated rig.
std::shared_ptr<recording::Recording> simulate(const std::string& profile_toml, const std::string& source,
                                               std::uint64_t seed, const std::string& posture,
                                               std::array<double, 2> place, int sets) {
  return std::make_shared<recording::Recording>(unlocked([&]() -> Result<recording::Recording> {
    TONUS_TRY_ASSIGN(auto profile, simulation::parse_profile(profile_toml, source));
    profile.seed = seed;
    simulated::Procedure procedure;
    procedure.sets = sets;
    return simulated::measure(profile, {posture, {place[0], place[1]}}, procedure);
  }));
}

/// (name, (x, y)) of the published postures, m in S.
std::vector<std::pair<std::string, std::array<double, 2>>> published_postures() {
  std::vector<std::pair<std::string, std::array<double, 2>>> all;
  for (const auto& posture : simulated::published_postures())
    all.push_back({posture.name, {posture.position[0], posture.position[1]}});
  return all;
}

std::span<const double> span_of(const DoubleArray& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// A trial as Python gives it: force, displacement, commanded or None, onset or None.
using GivenTrial =
    std::tuple<DoubleArray, DoubleArray, std::optional<DoubleArray>, std::optional<std::int64_t>>;

std::string identify_given(const std::vector<GivenTrial>& given, double rate, unsigned axes,
                           const std::pair<std::string, std::string>& units, double handle_mass,
                           std::array<double, 2> bias, const std::string& posture,
                           const py::kwargs& settings) {
  const auto request = request_of(settings);
  const ArrayCondition condition{axes, rate, {units.first, units.second}, handle_mass, bias, posture};
  std::vector<ArrayTrial> trials;
  trials.reserve(given.size());
  for (const auto& [force, displacement, commanded, onset] : given) {
    trials.push_back({span_of(force), span_of(displacement),
                      commanded ? span_of(*commanded) : std::span<const double>(), onset});
  }
  return results_text(unlocked([&] { return identify_arrays(trials, condition, request); }));
}

}  // namespace

void bind_recordings(py::module_& module) {
  py::class_<recording::Recording, std::shared_ptr<recording::Recording>>(module, "Recording")
      .def("facts", &facts_of)
      .def("arrays", &recording_arrays)
      .def("identify", &identify_recording);
  py::class_<recording::Dataset>(module, "Dataset")
      .def(py::init([](const std::string& root) {
        return std::make_unique<recording::Dataset>(unlocked([&] { return recording::Dataset::open(root); }));
      }))
      .def("__len__", &recording::Dataset::runs)
      .def("read", &read_recording, py::arg("index"), py::arg("force_sign"))
      .def("identify", &identify_whole, py::arg("force_sign"));
  module.def("simulate", &simulate, py::arg("profile_toml"), py::arg("source"), py::arg("seed"),
             py::arg("posture"), py::arg("place"), py::arg("sets"));
  module.def("published_postures", &published_postures);
  module.def("identify_arrays", &identify_given, py::arg("trials"), py::arg("rate"), py::arg("axes"),
             py::arg("units"), py::arg("handle_mass"), py::arg("bias"), py::arg("posture"));
}

}  // namespace tonus::python
