#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "services/core/result.hpp"

/// Who may do what. A viewer sees everything and can stop the rig; an operator can also steer.
namespace tonus::dashboard {

enum class Role : std::uint8_t { kView, kOperate };

[[nodiscard]] const char* role_name(Role role);

/// Secrets, each of 16 to 256 letters, digits and any of - . _ ~ + / =. Without any, whoever reaches the
/// gateway is an operator; then it listens to this machine only.
struct Tokens {
  std::vector<std::string> view;
  std::vector<std::string> operate;

  [[nodiscard]] bool is_empty() const { return view.empty() && operate.empty(); }
};

/// A TOML file with `view = ["..."]` and `operate = ["..."]`, readable by its owner only. kInvalidArgument
/// names the line that is wrong, never a token.
[[nodiscard]] Result<Tokens> load_tokens(const std::filesystem::path& file);

/// What a request says of itself; empty: not said.
struct Visit {
  std::string host{};           ///< Header "Host".
  std::string origin{};         ///< Header "Origin": set by browsers, and by them only.
  std::string authorization{};  ///< Header "Authorization".
  std::string query_token{};    ///< "token" of the target's query: browsers cannot set a WebSocket's headers.
  bool is_tls = false;
};

struct Refusal {
  int http_status = 403;
  std::string reason;  ///< One line, without any secret.
};

class Access {
 public:
  /// `origins`: other pages than the gateway's own that may connect, "https://app.example.org"; "*" for any.
  Access(Tokens tokens, std::vector<std::string> origins);

  /// The visitor's role. Pages of a foreign origin are refused; without tokens also hosts that are not this
  /// machine's own names, so that no page of elsewhere reaches the gateway by a name it has made up.
  [[nodiscard]] std::variant<Role, Refusal> admit(const Visit& visit) const;

  /// Whether it is one of the tokens; false for everything that is not of a token's form.
  [[nodiscard]] bool knows(std::string_view token) const;

  [[nodiscard]] bool needs_token() const { return !tokens_.is_empty(); }

 private:
  [[nodiscard]] std::optional<Role> role_of(std::string_view token) const;
  [[nodiscard]] bool is_origin_good(const Visit& visit) const;
  Tokens tokens_;
  std::vector<std::string> origins_;
};

/// 127.0.0.0/8, ::1 or localhost; with or without a port.
[[nodiscard]] bool is_loopback_name(std::string_view host);

/// Whether two texts are the same, in a time that does not depend on where they differ, nor on whether their
/// lengths do.
[[nodiscard]] bool is_same_secret(std::string_view a, std::string_view b);

/// The value of `name` in a header "Cookie"; empty: not there.
[[nodiscard]] std::string cookie_value(std::string_view header, std::string_view name);

/// The value of `name` in a target's query ("/x?token=abc"), percent signs decoded; empty: not there.
[[nodiscard]] std::string query_value(std::string_view target, std::string_view name);

}  // namespace tonus::dashboard
