#include "services/recording/file_name.hpp"

#include <algorithm>
#include <charconv>
#include <span>
#include <spdlog/fmt/fmt.h>

#include "services/core/crc32c.hpp"

namespace tonus::recording {
namespace {

constexpr std::string_view kSuffix = "_motion.tsv";

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool is_label(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), is_letter_or_digit);
}

/// As others write them: newer versions of BIDS have '+' in labels.
bool is_foreign_label(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c == '+' || is_letter_or_digit(c); });
}

}  // namespace

Result<void> take_labels(const std::filesystem::path& motion_file, Recording& recording) {
  const auto refuse = [&motion_file](const std::string& reason) {
    return fail(ErrorCode::kInvalidArgument,
                motion_file.string() + ": file name is not allowed; expected " + reason);
  };
  const std::string name = motion_file.filename().string();
  std::string_view rest(name);
  rest.remove_suffix(kSuffix.size());
  recording.participant = {};
  recording.session.clear();
  recording.task.clear();
  recording.tracking_system.clear();
  recording.acquisition.clear();
  recording.run = 1;
  while (!rest.empty()) {
    const std::size_t end = rest.find('_');
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    const std::size_t hyphen = part.find('-');
    if (hyphen == std::string_view::npos || !is_foreign_label(part.substr(hyphen + 1))) {
      return refuse(fmt::format("parts of the form entity-label, not '{}'", part));
    }
    const std::string_view entity = part.substr(0, hyphen);
    const std::string_view label = part.substr(hyphen + 1);
    if (entity == "sub") recording.participant.id = part;
    if (entity == "ses") recording.session = part;
    if (entity == "task") recording.task = label;
    if (entity == "tracksys") recording.tracking_system = label;
    if (entity == "acq") recording.acquisition = label;
    if (entity == "run") {
      const auto parsed = std::from_chars(label.data(), label.data() + label.size(), recording.run);
      if (parsed.ec != std::errc{} || parsed.ptr != label.data() + label.size()) {
        return refuse(fmt::format("a whole number as run, not '{}'", label));
      }
    }
  }
  if (recording.participant.id.empty()) return refuse("sub-<label>");
  if (recording.task.empty()) return refuse("task-<label>");
  if (recording.tracking_system.empty()) return refuse("tracksys-<label>");
  return {};
}

std::filesystem::path run_folder(const Recording& recording) {
  return std::filesystem::path(recording.participant.id) / recording.session / "motion";
}

Result<std::string> run_stem(const Recording& recording, bool with_tracking_system) {
  const auto refuse = [&recording](const char* what, std::string_view value, const char* allowed) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("recording {}: {} '{}' is not allowed; expected {}",
                                                         describe(recording), what, value, allowed));
  };
  const auto is_prefixed = [](std::string_view text, std::string_view prefix) {
    return text.starts_with(prefix) && is_label(text.substr(prefix.size()));
  };
  constexpr const char* kAllowed = "letters and digits";
  if (!is_prefixed(recording.participant.id, "sub-")) {
    return refuse("participant", recording.participant.id, "'sub-' with letters and digits");
  }
  if (!recording.session.empty() && !is_prefixed(recording.session, "ses-")) {
    return refuse("session", recording.session, "'ses-' with letters and digits");
  }
  if (!is_label(recording.task)) return refuse("task", recording.task, kAllowed);
  if (!is_label(recording.tracking_system))
    return refuse("tracking system", recording.tracking_system, kAllowed);
  if (!recording.acquisition.empty() && !is_label(recording.acquisition)) {
    return refuse("acquisition", recording.acquisition, kAllowed);
  }
  if (recording.run < 1) return refuse("run", std::to_string(recording.run), "1 or more");

  std::string stem = recording.participant.id;
  if (!recording.session.empty()) stem += "_" + recording.session;
  stem += "_task-" + recording.task;
  if (with_tracking_system) stem += "_tracksys-" + recording.tracking_system;
  if (!recording.acquisition.empty()) stem += "_acq-" + recording.acquisition;
  return stem + fmt::format("_run-{:02}", recording.run);
}

std::string to_label(std::string_view name) {
  if (name.empty() || is_label(name)) return std::string(name);
  std::string label;
  std::copy_if(name.begin(), name.end(), std::back_inserter(label), is_letter_or_digit);
  return label + fmt::format("x{:08x}", crc32c(std::as_bytes(std::span(name))));
}

}  // namespace tonus::recording
