#include "services/core/passwords.hpp"

#include <regex>

namespace tonus {

std::string without_passwords(const std::string& text) {
  static const std::regex kUserInfo(R"((://[^:/@\s"']*):[^@\s"']*@)");
  static const std::regex kParameter(R"((password=)[^&\s"']*)", std::regex::icase);
  return std::regex_replace(std::regex_replace(text, kUserInfo, "$1:***@"), kParameter, "$1***");
}

}  // namespace tonus
