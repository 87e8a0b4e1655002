#pragma once

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::cli {

/// Gives every command of `tonus` its example, at the end of its --help and of its part of the manual page.
void add_examples(CLI::App& app);

}  // namespace tonus::cli
