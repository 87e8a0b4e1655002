#pragma once

#include <string>

namespace tonus::recording {

/// Appends the shortest decimal text that reads back as the same double; whole numbers without exponent.
void append_number(std::string& text, double value);

}  // namespace tonus::recording
