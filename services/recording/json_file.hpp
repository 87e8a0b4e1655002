#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/core/result.hpp"

namespace tonus::recording {

/// A JSON object from a file, or from several of which a more special one overrides the keys of the others;
/// asked by dotted names ("Rig.HandleMass_kg"). Every refusal names the file, the key, the value and what is
/// allowed.
class JsonFile {
 public:
  /// kNotFound, kIo; kInvalidArgument with line and column where it is not JSON or not an object.
  [[nodiscard]] static Result<JsonFile> read(const std::filesystem::path& file);
  /// `files` from the most general to the most special; at least one.
  [[nodiscard]] static Result<JsonFile> read(const std::vector<std::filesystem::path>& files);

  /// An object without keys, which answers as a file would that does not state anything.
  explicit JsonFile(std::filesystem::path file) { add(std::move(file), nlohmann::json::object()); }

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

  /// Of the most special file.
  [[nodiscard]] const std::filesystem::path& path() const { return files_.front().path; }

 private:
  struct File {
    std::filesystem::path path;
    nlohmann::json root;
  };

  JsonFile() = default;
  void add(std::filesystem::path path, nlohmann::json root) {
    files_.insert(files_.begin(), {std::move(path), std::move(root)});
  }
  /// The most special file that has the first name of `key`, else the most special one.
  [[nodiscard]] const File& file_with(std::string_view key) const;
  [[nodiscard]] const nlohmann::json* find(std::string_view key) const;

  std::vector<File> files_;  ///< The most special first; never empty.
};

}  // namespace tonus::recording
