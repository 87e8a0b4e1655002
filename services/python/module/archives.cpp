#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "analysis_service/offline/request.hpp"
#include "analysis_service/offline/results_json.hpp"
#include "services/contract/message_json.hpp"
#include "services/core/json_text.hpp"
#include "services/python/module/arrays.hpp"
#include "services/python/module/bindings.hpp"
#include "services/python/module/identify.hpp"
#include "services/python/module/request.hpp"
#include "services/python/module/unlocked.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"

namespace tonus::python {
namespace {

namespace py = pybind11;
using nlohmann::json;

/// A store that is read, by one thread at a time.
struct OpenArchive {
  std::unique_ptr<store::Store> store;
  std::mutex mutex;
};

/// A session as it was when it was read, and the archive that its samples come from.
struct OpenSession {
  std::shared_ptr<OpenArchive> archive;
  store::Session content;
};

/// Runs work(store) without the interpreter's lock; other threads wait for the archive there.
template <typename Work>
auto with_store(OpenArchive& archive, const Work& work) {
  return unlocked([&] {
    const std::lock_guard lock(archive.mutex);
    return work(*archive.store);
  });
}

json session_json(const store::SessionRecord& record) {
  return {{"id", to_hex(record.session)},
          {"rig_id", to_hex(record.rig)},
          {"subject", record.subject},
          {"protocol_name", record.protocol_name},
          {"seed", record.seed},
          {"planned_trials", record.planned_trials},
          {"started_at", record.started_at},
          {"software_version", record.software_version}};
}

std::shared_ptr<OpenArchive> open_archive(const std::string& name) {
  auto archive = std::make_shared<OpenArchive>();
  archive->store = unlocked([&] { return store::open_store_for_reading(name); });
  return archive;
}

std::string sessions_text(OpenArchive& archive) {
  json list = json::array();
  for (const auto& record : with_store(archive, [](store::Store& s) { return store::list_sessions(s); }))
    list.push_back(session_json(record));
  return json_text(list, -1);
}

std::shared_ptr<OpenSession> open_session(const std::shared_ptr<OpenArchive>& archive,
                                          const std::string& wanted) {
  auto content =
      with_store(*archive, [&](store::Store& store) { return store::read_found_session(store, wanted); });
  return std::make_shared<OpenSession>(OpenSession{archive, std::move(content)});
}

/// The session, its state and its rig's units.
std::string facts_of(const OpenSession& session) {
  const store::Session& content = session.content;
  json facts = session_json(content.record);
  facts["plan"] = contract::message_json(content.plan);
  facts["state"] = content.state ? contract::message_json(*content.state) : json(nullptr);
  facts["is_whole"] = content.is_whole();
  facts["notes"] = json::array();
  for (const auto& note : content.notes) facts["notes"].push_back(contract::message_json(note.value));
  const bool is_described = !content.descriptions.empty();
  const v1::RigDescription none;
  const v1::RigDescription& rig = is_described ? content.descriptions.back().value : none;
  facts["displacement_unit"] = is_described ? json(rig.displacement_unit()) : json(nullptr);
  facts["force_unit"] = is_described ? json(rig.force_unit()) : json(nullptr);
  return json_text(facts, -1);
}

std::string trials_text(const OpenSession& session) {
  json list = json::array();
  for (const auto& trial : session.content.trials) {
    json object{{"attempt", trial.attempt}, {"trial_id", to_hex(trial.trial)}};
    object["outcome"] = trial.outcome ? contract::message_json(trial.outcome->value) : json(nullptr);
    const auto verdict = store::standing_verdict(trial);
    object["verdict"] = verdict ? contract::message_json(*verdict) : json(nullptr);
    object["review"] = trial.review ? contract::message_json(trial.review->value) : json(nullptr);
    object["program"] = trial.outcome   ? contract::message_json(trial.outcome->value.program())
                        : trial.command ? contract::message_json(trial.command->value.program())
                                        : json(nullptr);
    object["rows"] = trial.record ? trial.record->range().count() : 0;
    object["is_certified"] = trial.record && trial.record->is_certified;
    object["why_not_counted"] = store::why_not_counted(trial);
    list.push_back(std::move(object));
  }
  return json_text(list, -1);
}

/// Arrays of the trials with these numbers in the session's list, one after the other, and for each its first
/// row, number of rows, and onset from the first row.
py::tuple read_trials(const OpenSession& session, const std::vector<std::size_t>& numbers) {
  std::vector<const store::SessionTrial*> trials;
  trials.reserve(numbers.size());
  for (const std::size_t number : numbers) trials.push_back(&session.content.trials.at(number));
  auto read = with_store(*session.archive,
                         [&](store::Store& store) { return read_signals(store, session.content, trials); });
  py::list places;
  for (const TrialRows& place : read.trials)
    places.append(py::make_tuple(place.first, place.rows, place.onset));
  return py::make_tuple(arrays_of(std::make_shared<const Signals>(std::move(read.signals))), places);
}

/// Of a trial: (name, type, unit, rate, values, time of the first value) of each auxiliary channel.
py::list read_trial_auxiliary(const OpenSession& session, std::size_t number) {
  const store::SessionTrial& trial = session.content.trials.at(number);
  const auto found = with_store(
      *session.archive, [&](store::Store& store) { return read_auxiliary(store, session.content, trial); });
  py::list channels;
  for (const AuxiliarySeries& one : found.series) {
    const py::array_t<float> values(static_cast<py::ssize_t>(one.values.size()), one.values.data());
    channels.append(py::make_tuple(one.channel.name, one.channel.type, one.channel.unit, one.channel.rate,
                                   values, found.first_sample_time + one.time_of(0)));
  }
  return channels;
}

std::string published_text(const OpenSession& session) {
  return results_text(identification::published_results(session.content));
}

std::string identify_session(const OpenSession& session, const py::kwargs& settings) {
  const auto request = request_of(settings);
  return results_text(with_store(
      *session.archive, [&](store::Store& store) -> Result<std::vector<identification::OfflineEstimate>> {
        TONUS_TRY_ASSIGN(const auto analyses, identification::analyses_of(request));
        return identification::identify_archived(store, to_hex(session.content.record.session), analyses);
      }));
}

}  // namespace

void bind_archives(py::module_& module) {
  py::class_<OpenArchive, std::shared_ptr<OpenArchive>>(module, "Archive")
      .def(py::init(&open_archive))
      .def("sessions", &sessions_text)
      .def("session", &open_session, py::arg("wanted"));
  py::class_<OpenSession, std::shared_ptr<OpenSession>>(module, "Session")
      .def("facts", &facts_of)
      .def("trials", &trials_text)
      .def("read", &read_trials, py::arg("numbers"))
      .def("auxiliary", &read_trial_auxiliary, py::arg("number"))
      .def("published", &published_text)
      .def("identify", &identify_session);
  module.def("default_store",
             [](const std::string& folder) { return store::default_store(folder).string(); });
}

}  // namespace tonus::python
