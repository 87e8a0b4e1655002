#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::recording {

/// A JSON object from a file, asked by dotted names ("Rig.HandleMass_kg"). Every refusal names the file, the
/// key, the value and what is allowed.
class JsonFile {
 public:
  /// kNotFound, kIo; kInvalidArgument with line and column where it is not JSON or not an object.
  [[nodiscard]] static Result<JsonFile> read(const std::filesystem::path& file);

  /// An object without keys, which answers as a file would that does not state anything.
  explicit JsonFile(std::filesystem::path file) : file_(std::move(file)), root_(nlohmann::json::object()) {}

  [[nodiscard]] bool has(std::string_view key) const { return find(key) != nullptr; }

  /// A finite number; `fallback` where the key is not there, an error if there is none.
  [[nodiscard]] Result<double> number(std::string_view key, std::optional<double> fallback = {}) const;

  /// `count` finite numbers, in an array.
  [[nodiscard]] Result<std::vector<double>> numbers(std::string_view key, std::size_t count) const;

  /// A square matrix as an array of `size` rows; row-major.
  [[nodiscard]] Result<std::vector<double>> matrix(std::string_view key, std::size_t size) const;

  /// A text; `fallback` where the key is not there.
  [[nodiscard]] Result<std::string> text(std::string_view key, std::string_view fallback) const;

  [[nodiscard]] Error refuse(std::string_view key, std::string_view allowed) const;

  [[nodiscard]] const std::filesystem::path& path() const { return file_; }

 private:
  [[nodiscard]] const nlohmann::json* find(std::string_view key) const;

  std::filesystem::path file_;
  nlohmann::json root_;
};

}  // namespace tonus::recording
