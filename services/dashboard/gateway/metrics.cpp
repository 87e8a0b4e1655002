#include "services/dashboard/gateway/metrics.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <spdlog/fmt/fmt.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/core/places.hpp"
#include "services/core/text.hpp"

namespace tonus::dashboard {
namespace {

/// A label's value as the format wants it.
std::string escaped(std::string_view value) {
  std::string text;
  for (const char c : as_utf8(value)) {
    if (c == '\n') {
      text += "\\n";
    } else {
      if (c == '\\' || c == '"') text += '\\';
      text += c;
    }
  }
  return text;
}

template <typename T>
std::vector<T> newest(const Hub& hub, const topics::Topic<T>& topic) {
  std::vector<T> all;
  for (const PassedMessage& message : hub.latest(topic.spec.name)) {
    if (auto value = bus::decode<T>(*message.payload)) all.push_back(std::move(*value));
  }
  return all;
}

template <typename Octets>
std::string hex(const Octets& id) {
  return to_hex(Id(id));
}

/// One metric with a sample for each of `all`.
template <typename T, typename LabelsOf, typename ValueOf>
void each(MetricsText& text, const std::vector<T>& all, std::string_view name, std::string_view kind,
          std::string_view help, const LabelsOf& labels_of, const ValueOf& value_of) {
  if (all.empty()) return;
  text.metric(name, kind, help);
  for (const T& one : all) text.sample(value_of(one), labels_of(one));
}

void add_rigs(MetricsText& text, const std::vector<v1::RigState>& rigs) {
  const auto labels = [](const v1::RigState& s) { return MetricsText::Labels{{"rig", hex(s.rig_id())}}; };
  const auto add = [&](std::string_view name, std::string_view kind, std::string_view help,
                       const auto& value) { each(text, rigs, name, kind, help, labels, value); };
  using State = v1::RigState;
  add("tonus_rig_samples_total", "counter", "Samples that the rig has acquired since its agent's start.",
      [](const State& s) -> std::uint64_t { return s.next_sequence(); });
  add("tonus_rig_receipted_samples_total", "counter",
      "Samples since the agent's start for which the rig has the archive's receipt.",
      [](const State& s) -> std::uint64_t { return s.received_through(); });
  add("tonus_rig_dropped_samples_total", "counter", "Samples that the loop could not hand over.",
      [](const State& s) -> std::uint64_t { return s.dropped_samples(); });
  add("tonus_rig_spool_bytes", "gauge", "Size of the rig's spool.",
      [](const State& s) -> std::uint64_t { return s.spool_bytes(); });
  add("tonus_rig_held", "gauge", "1 while the rig is held and moves nothing until an operator clears it.",
      [](const State& s) -> std::uint64_t { return s.mode() == v1::RIG_HELD ? 1 : 0; });
  add("tonus_rig_holds_total", "counter", "Number of the rig's newest hold.",
      [](const State& s) -> std::uint64_t { return s.hold_number(); });
  add("tonus_rig_in_trial", "gauge", "1 while a trial runs.",
      [](const State& s) -> std::uint64_t { return s.mode() == v1::RIG_IN_TRIAL ? 1 : 0; });
  add("tonus_rig_faults", "gauge", "Faults that are present now.", [](const State& s) -> std::uint64_t {
    return static_cast<std::uint64_t>(__builtin_popcountll(s.fault_bits()));
  });
}

void add_timing(MetricsText& text, const std::vector<v1::RigTiming>& rigs) {
  const auto labels = [](const v1::RigTiming& t) { return MetricsText::Labels{{"rig", hex(t.rig_id())}}; };
  const auto add = [&](std::string_view name, std::string_view kind, std::string_view help,
                       const auto& value) { each(text, rigs, name, kind, help, labels, value); };
  using Timing = v1::RigTiming;
  add("tonus_rig_period_seconds", "gauge", "Period of the control loop.",
      [](const Timing& t) -> double { return t.period_s(); });
  add("tonus_rig_cycles_total", "counter", "Cycles of the control loop since the agent's start.",
      [](const Timing& t) -> std::uint64_t { return t.cycles(); });
  add("tonus_rig_overruns_total", "counter", "Cycles that began after whole periods had been missed.",
      [](const Timing& t) -> std::uint64_t { return t.overruns(); });
  add("tonus_rig_missed_periods_total", "counter", "Periods in which no cycle began.",
      [](const Timing& t) -> std::uint64_t { return t.missed_periods(); });
  add("tonus_rig_worst_lateness_seconds", "gauge", "Lateness of the latest cycle since the agent's start.",
      [](const Timing& t) -> double { return 1e-9 * static_cast<double>(t.worst_lateness_ns()); });
  if (rigs.empty()) return;
  // The rig knows how many cycles were how late, and not the sum of all latenesses: no histogram by name.
  text.metric("tonus_rig_late_cycles_total", "counter",
              "Cycles that began at most le seconds late; fit for histogram_quantile().");
  for (const Timing& timing : rigs) {
    const auto& counts = timing.lateness_count();
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      sum += counts[i];
      const bool is_last = i + 1 == counts.size();
      text.sample(sum,
                  {{"rig", hex(timing.rig_id())},
                   {"le", is_last ? "+Inf" : fmt::format("{:g}", std::ldexp(1e-6, static_cast<int>(i)))}});
    }
  }
}

void add_services(MetricsText& text, std::vector<v1::ServiceHealth> services) {
  std::erase_if(services, [](const v1::ServiceHealth& health) { return health.is_leaving(); });
  const auto labels = [](const v1::ServiceHealth& h) {
    return MetricsText::Labels{
        {"service", h.name()}, {"host", h.host()}, {"instance_id", hex(h.instance_id())}};
  };
  const auto add = [&](std::string_view name, std::string_view kind, std::string_view help,
                       const auto& value) { each(text, services, name, kind, help, labels, value); };
  using Health = v1::ServiceHealth;
  add("tonus_service_ready", "gauge", "1 while the service can do its job.",
      [](const Health& h) -> std::uint64_t { return h.is_ready() ? 1 : 0; });
  add("tonus_service_start_time_seconds", "gauge", "When the service started, seconds since 1970, UTC.",
      [](const Health& h) -> double { return 1e-9 * static_cast<double>(h.started_ns()); });
  add("tonus_service_lag_seconds", "gauge", "Age of the newest input when it was handled.",
      [](const Health& h) -> double { return h.lag_s(); });
  add("tonus_service_queue_items", "gauge", "Items that wait in the service's queues.",
      [](const Health& h) -> std::uint64_t { return h.queue_depth(); });
  add("tonus_service_dropped_total", "counter", "Messages that the service has dropped since its start.",
      [](const Health& h) -> std::uint64_t { return h.dropped(); });
}

void add_sessions(MetricsText& text, std::vector<v1::SessionState> sessions) {
  const auto is_over = [](const v1::SessionState& s) {
    return s.phase() == v1::SESSION_COMPLETED || s.phase() == v1::SESSION_ABORTED;
  };
  std::erase_if(sessions, is_over);
  const auto labels = [](const v1::SessionState& s) {
    return MetricsText::Labels{{"session", hex(s.session_id())}};
  };
  const auto add = [&](std::string_view name, std::string_view help, const auto& value) {
    each(text, sessions, name, "gauge", help, labels, value);
  };
  using State = v1::SessionState;
  add("tonus_session_planned_trials", "Trials of the session that goes on, as planned.",
      [](const State& s) -> std::uint64_t { return s.planned(); });
  add("tonus_session_counted_trials", "Trials that are valid and archived.",
      [](const State& s) -> std::uint64_t { return s.counted(); });
  add("tonus_session_rejected_trials", "Trials that were rejected and are run again.",
      [](const State& s) -> std::uint64_t { return s.rejected(); });
  add("tonus_session_remaining_seconds", "Estimated rest of the session, in experiment time.",
      [](const State& s) -> double { return s.remaining_s(); });
}

void add(MetricsText& text, std::string_view name, std::string_view help, const Histogram& histogram) {
  text.metric(name, "histogram", help);
  for (std::size_t i = 0; i < Histogram::kEnds.size(); ++i)
    text.sample(histogram.count_within(i), {{"le", fmt::format("{:g}", Histogram::kEnds[i])}}, "_bucket");
  text.sample(histogram.count(), {{"le", "+Inf"}}, "_bucket");
  text.sample(histogram.sum(), {}, "_sum").sample(histogram.count(), {}, "_count");
}

void add_gateway(MetricsText& text, const Hub& hub, std::uint64_t arrival_drops, std::size_t connections) {
  text.metric("tonus_gateway_clients", "gauge", "WebSocket clients.")
      .sample(static_cast<std::uint64_t>(hub.clients()));
  text.metric("tonus_gateway_connections", "gauge", "Connections, those without a token included.")
      .sample(static_cast<std::uint64_t>(connections));
  text.metric("tonus_gateway_waiting_messages", "gauge", "Messages that wait to be sent to clients.")
      .sample(static_cast<std::uint64_t>(hub.waiting_messages()));
  text.metric("tonus_gateway_thinned_messages_total", "counter", "Live messages left out for slow clients.")
      .sample(hub.thinned());
  text.metric("tonus_gateway_arrival_drops_total", "counter", "Live messages left out before any client.")
      .sample(arrival_drops);
  text.metric("tonus_gateway_refusals_total", "counter", "What was refused, by kind.");
  for (std::size_t kind = 0; kind < static_cast<std::size_t>(Refused::kCount); ++kind) {
    const auto refused = static_cast<Refused>(kind);
    text.sample(hub.refused(refused), {{"kind", refused_name(refused)}});
  }
}

/// The end of the first certificate of a PEM file, seconds since 1970, UTC.
std::optional<std::int64_t> end_of_certificate(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "re"), std::fclose);
  if (!file) return std::nullopt;
  const std::unique_ptr<X509, void (*)(X509*)> certificate(
      PEM_read_X509(file.get(), nullptr, nullptr, nullptr), X509_free);
  std::tm end{};
  if (!certificate || ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &end) != 1) return std::nullopt;
  return ::timegm(&end);
}

}  // namespace

MetricsText& MetricsText::metric(std::string_view name, std::string_view kind, std::string_view help) {
  name_ = name;
  text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, kind);
  return *this;
}

MetricsText& MetricsText::sample(double value, const Labels& labels, std::string_view suffix) {
  const std::string number = std::isnan(value)   ? "NaN"
                             : std::isinf(value) ? (value > 0 ? "+Inf" : "-Inf")
                                                 : fmt::format("{}", value);
  line(number, labels, suffix);
  return *this;
}

MetricsText& MetricsText::sample(std::uint64_t value, const Labels& labels, std::string_view suffix) {
  line(std::to_string(value), labels, suffix);
  return *this;
}

void MetricsText::line(const std::string& value, const Labels& labels, std::string_view suffix) {
  text_ += name_;
  text_ += suffix;
  char separator = '{';
  for (const auto& [label, content] : labels) {
    text_ += fmt::format("{}{}=\"{}\"", separator, label, escaped(content));
    separator = ',';
  }
  if (!labels.empty()) text_ += '}';
  text_ += ' ' + value + '\n';
}

std::string bus_metrics(const Hub& hub, std::uint64_t arrival_drops, std::size_t connections) {
  MetricsText text;
  add_rigs(text, newest(hub, topics::kRigState));
  add_timing(text, newest(hub, topics::kRigTiming));
  add_services(text, newest(hub, topics::kServiceHealth));
  add_sessions(text, newest(hub, topics::kSessionState));
  add(text, "tonus_verdict_latency_seconds", "From the end of a trial to its verdict.",
      hub.latency().verdicts());
  add(text, "tonus_estimate_latency_seconds", "From the end of a trial to the first estimate that counts it.",
      hub.latency().estimates());
  add_gateway(text, hub, arrival_drops, connections);
  return text.take();
}

std::string file_metrics(const std::string& store, const std::string& certificate) {
  MetricsText text;
  std::error_code error;
  const bool is_file = !is_url(store);
  if (const auto size = is_file ? std::filesystem::file_size(store, error) : 0; is_file && !error)
    text.metric("tonus_archive_bytes", "gauge", "Size of the archive's file.").sample(std::uint64_t{size});
  const auto folder = std::filesystem::absolute(store, error).parent_path();
  if (const auto disk = std::filesystem::space(folder, error); is_file && !error) {
    text.metric("tonus_archive_disk_free_bytes", "gauge", "Free on the archive's disk, for its user.")
        .sample(std::uint64_t{disk.available});
    text.metric("tonus_archive_disk_bytes", "gauge", "Size of the archive's disk.")
        .sample(std::uint64_t{disk.capacity});
  }
  if (const auto end = certificate.empty() ? std::nullopt : end_of_certificate(certificate)) {
    text.metric("tonus_tls_certificate_expiry_timestamp_seconds", "gauge",
                "When the gateway's certificate ends, seconds since 1970, UTC.")
        .sample(static_cast<double>(*end));
  }
  return text.take();
}

}  // namespace tonus::dashboard
