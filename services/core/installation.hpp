#pragma once

#include <filesystem>

namespace tonus {

/// Where the running program is installed, <prefix>/bin, and what belongs to it: whichever prefix it was
/// installed, unpacked or built into.
struct Installation {
  std::filesystem::path programs;       ///< <prefix>/bin
  std::filesystem::path helpers;        ///< programs that only other programs start: <prefix>/libexec/tonus
  std::filesystem::path share;          ///< <prefix>/share/tonus
  std::filesystem::path configuration;  ///< <prefix>/etc/tonus; /etc/tonus where the prefix is /usr
};

[[nodiscard]] Installation installation();

/// The same for a program at `program`.
[[nodiscard]] Installation installation_of(const std::filesystem::path& program);

}  // namespace tonus
