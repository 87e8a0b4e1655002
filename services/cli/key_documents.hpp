#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/config/checked_table.hpp"
#include "services/explain/key_texts.hpp"

namespace tonus::cli {

/// A kind of TOML file, with every key that its reader asks for and what each means.
struct KeyDocument {
  std::string name;   ///< "protocol", "profile", "cohort", "comedi".
  std::string about;  ///< A sentence.
  std::vector<config::Key> keys;
  std::span<const explain::KeyText> texts;
  std::vector<std::string> kinds;  ///< Of keys that not every file of this kind has: where. Beside keys.
};

[[nodiscard]] std::vector<KeyDocument> key_documents();

/// What the key means; empty where it has no text.
[[nodiscard]] std::string_view meaning_of(const KeyDocument& document, std::string_view key);

/// The keys of this name: "bias.force_N", or its last part "force_N". Lines for a terminal; empty: none.
[[nodiscard]] std::string explained_keys(std::string_view name);

/// The manual's page of all keys, in Markdown. (The options' keys are in options.md.)
[[nodiscard]] std::string keys_page();

}  // namespace tonus::cli
