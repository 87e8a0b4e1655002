#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/dashboard/gateway/hub.hpp"

/// /metrics: what the system is doing, in the text format of Prometheus (version 0.0.4), for monitoring.
namespace tonus::dashboard {

/// Text in the format: each metric with HELP and TYPE once, then its samples. Names and units follow
/// Prometheus' rules: base units, "_total" for what only grows.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string>>;

  /// Begins a metric; `kind` is counter, gauge or histogram.
  MetricsText& metric(std::string_view name, std::string_view kind, std::string_view help);

  /// A sample of the metric; `suffix` is "", "_bucket", "_sum" or "_count". Labels may hold anything.
  MetricsText& sample(double value, const Labels& labels = {}, std::string_view suffix = "");
  MetricsText& sample(std::uint64_t value, const Labels& labels = {}, std::string_view suffix = "");

  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void line(const std::string& value, const Labels& labels, std::string_view suffix);

  std::string name_;
  std::string text_;
};

/// What the gateway has heard: rigs, services, sessions, results, and itself. What nobody has said is left
/// out, not 0.
[[nodiscard]] std::string bus_metrics(const Hub& hub, std::uint64_t arrival_drops, std::size_t connections);

/// The archive's disk and the certificate's end; reads files, which may take its time. `certificate`: a PEM
/// file, empty where there is none. What cannot be read is left out.
[[nodiscard]] std::string file_metrics(const std::string& store, const std::string& certificate);

}  // namespace tonus::dashboard
