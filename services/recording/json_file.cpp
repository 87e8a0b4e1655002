#include "services/recording/json_file.hpp"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

#include "services/core/text.hpp"
#include "services/recording/line_reader.hpp"

namespace tonus::recording {
namespace {

constexpr int kDeepest = 16;

std::optional<double> finite_number(const nlohmann::json& value) {
  if (!value.is_number()) return {};
  const double number = value.get<double>();
  if (!std::isfinite(number)) return {};
  return number;
}

/// Numbers of an array of the right length, or nothing.
std::optional<std::vector<double>> finite_numbers(const nlohmann::json& value, std::size_t count) {
  if (!value.is_array() || value.size() != count) return {};
  std::vector<double> numbers;
  for (const auto& element : value) {
    const auto number = finite_number(element);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

Result<nlohmann::json> read_object(const std::filesystem::path& file) {
  TONUS_TRY_ASSIGN(const auto text, read_unmarked(file));
  nlohmann::json root;
  try {
    // Deeper values than any of ours are left out, so that nobody's nesting exhausts the stack.
    root = nlohmann::json::parse(
        text, [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < kDeepest; });
  } catch (const nlohmann::json::exception& exception) {
    std::string reason = exception.what();
    if (const std::size_t place = reason.find("] "); place != std::string::npos) reason.erase(0, place + 2);
    return fail(ErrorCode::kInvalidArgument, file.string() + ": is not JSON: " + reason);
  }
  if (!root.is_object()) {
    return fail(ErrorCode::kInvalidArgument, file.string() + ": is not allowed; expected a JSON object");
  }
  return root;
}

}  // namespace

Result<JsonFile> JsonFile::read(const std::filesystem::path& file) {
  return read(std::vector<std::filesystem::path>{file});
}

Result<JsonFile> JsonFile::read(const std::vector<std::filesystem::path>& files) {
  JsonFile json;
  for (const auto& file : files) {
    TONUS_TRY_ASSIGN(auto root, read_object(file));
    json.add(file, std::move(root));
  }
  return json;
}

const JsonFile::File& JsonFile::file_with(std::string_view key) const {
  const std::string first(key.substr(0, key.find('.')));
  const auto found =
      std::ranges::find_if(files_, [&](const File& file) { return file.root.contains(first); });
  return found == files_.end() ? files_.front() : *found;
}

const nlohmann::json* JsonFile::find(std::string_view key) const {
  const nlohmann::json* value = &file_with(key).root;
  while (!key.empty()) {
    const std::size_t dot = key.find('.');
    if (!value->is_object()) return nullptr;
    const auto place = value->find(std::string(key.substr(0, dot)));
    if (place == value->end()) return nullptr;
    value = &*place;
    key.remove_prefix(dot == std::string_view::npos ? key.size() : dot + 1);
  }
  return value;
}

Result<double> JsonFile::number(std::string_view key, std::optional<double> fallback) const {
  const nlohmann::json* value = find(key);
  if (value == nullptr && fallback) return *fallback;
  const auto number = value == nullptr ? std::optional<double>() : finite_number(*value);
  if (!number) return refuse(key, "a number");
  return *number;
}

Result<std::vector<double>> JsonFile::numbers(std::string_view key, std::size_t count) const {
  const nlohmann::json* value = find(key);
  auto numbers = value == nullptr ? std::optional<std::vector<double>>() : finite_numbers(*value, count);
  if (!numbers) return refuse(key, fmt::format("an array of {} number{}", count, count == 1 ? "" : "s"));
  return *std::move(numbers);
}

Result<std::vector<double>> JsonFile::matrix(std::string_view key, std::size_t size) const {
  const nlohmann::json* value = find(key);
  std::vector<double> elements;
  if (value != nullptr && value->is_array() && value->size() == size) {
    for (const auto& row : *value) {
      const auto numbers = finite_numbers(row, size);
      if (numbers) elements.insert(elements.end(), numbers->begin(), numbers->end());
    }
  }
  if (elements.size() != size * size) {
    return refuse(key, fmt::format("an array of {0} row{1} of {0} number{1}", size, size == 1 ? "" : "s"));
  }
  return elements;
}

Result<std::string> JsonFile::text(std::string_view key, std::string_view fallback) const {
  const nlohmann::json* value = find(key);
  if (value == nullptr) return std::string(fallback);
  if (!value->is_string()) return refuse(key, "a text");
  return shown(value->get<std::string>());
}

Error JsonFile::refuse(std::string_view key, std::string_view allowed) const {
  const nlohmann::json* value = find(key);
  if (value == nullptr) {
    return fail(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} is missing; expected {}", path().string(), key, allowed));
  }
  constexpr std::size_t kLongest = 60;
  std::string found = value->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (found.size() > kLongest) found = found.substr(0, kLongest) + "...";
  return fail(ErrorCode::kInvalidArgument, fmt::format("{}: {} = {} is not allowed; expected {}",
                                                       file_with(key).path.string(), key, found, allowed));
}

}  // namespace tonus::recording
