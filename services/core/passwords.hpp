#pragma once

#include <string>

namespace tonus {

/// `text` with "***" in the place of every password: of user:PASSWORD@ in a URL, of password=PASSWORD among
/// its parameters. For what is shown, published or kept.
[[nodiscard]] std::string without_passwords(const std::string& text);

}  // namespace tonus
