#pragma once

#include <string>

#include "services/core/result.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::runtime {

/// A text about a program's options, made from the options themselves, the source of --help, too:
///
///     man         manual page (roff)
///     bash, zsh   completion
///     reference   a chapter of docs/options.md
///     toml        every key of the section with its default, as comments: part of a tonus.toml
///     toml-common the same of the common options: its top
///
/// kInvalidArgument where there is no such kind.
[[nodiscard]] Result<std::string> option_document(const CLI::App& app, const std::string& kind);

}  // namespace tonus::runtime
