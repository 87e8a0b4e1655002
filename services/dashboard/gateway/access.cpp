#include "services/dashboard/gateway/access.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <openssl/crypto.h>
#include <openssl/sha.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include "services/config/checked_table.hpp"
#include "services/config/toml_text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::dashboard {
namespace {

constexpr std::size_t kShortestToken = 16;
constexpr std::size_t kLongestToken = 256;

Error refuse(const std::filesystem::path& file, const std::string& text) {
  return fail(ErrorCode::kInvalidArgument, fmt::format("{}: {}", file.string(), text));
}

bool is_token(std::string_view text) {
  return text.size() >= kShortestToken && text.size() <= kLongestToken &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 ||
                  std::string_view("-._~+/=").find(static_cast<char>(c)) != std::string_view::npos;
         });
}

Result<std::vector<std::string>> read_list(const toml::table& table, const char* name,
                                           const std::filesystem::path& file) {
  std::vector<std::string> tokens;
  const toml::node* node = table.get(name);
  if (node == nullptr) return tokens;
  const toml::array* list = node->as_array();
  if (list == nullptr) return refuse(file, fmt::format("{} is not allowed; expected a list of tokens", name));
  for (const toml::node& item : *list) {
    const auto text = item.value<std::string>();
    if (!text || !is_token(*text)) {
      return refuse(
          file,
          fmt::format("token {} of {} is not allowed; expected {} to {} letters, digits and any of -._~+/=",
                      tokens.size() + 1, name, kShortestToken, kLongestToken));
    }
    tokens.push_back(*text);
  }
  return tokens;
}

bool is_among(const std::vector<std::string>& tokens, std::string_view given) {
  bool is_found = false;
  for (const auto& token : tokens) is_found |= is_same_secret(token, given);
  return is_found;
}

std::string_view without_port(std::string_view host) {
  if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const int lower = std::tolower(static_cast<unsigned char>(c));
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

std::string percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0) {
      out.push_back(static_cast<char>(16 * hex_digit(text[i + 1]) + hex_digit(text[i + 2])));
      i += 2;
    } else {
      out.push_back(text[i]);
    }
  }
  return out;
}

}  // namespace

const char* role_name(Role role) { return role == Role::kOperate ? "operate" : "view"; }

Result<Tokens> load_tokens(const std::filesystem::path& file) {
  struct stat about {};
  if (stat(file.c_str(), &about) != 0) return refuse(file, std::strerror(errno));
  if ((about.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return refuse(file, fmt::format("mode: {:o} is not allowed; expected 600: others can read the tokens",
                                    about.st_mode & 0777U));
  }
  const auto text = read_text_file(file);
  if (!text) return text.error();
  TONUS_TRY_ASSIGN(const toml::table table, config::parse_toml(*text, file.string()));
  config::Findings findings{file.string(), {}, {}};
  config::CheckedTable checked(table, "", 0, findings);
  for (const char* key : {"view", "operate"}) (void)checked.has(key);
  checked.finish();
  if (findings.problem) return fail(ErrorCode::kInvalidArgument, *findings.problem);
  auto view = read_list(table, "view", file);
  if (!view) return view.error();
  auto operate = read_list(table, "operate", file);
  if (!operate) return operate.error();
  Tokens tokens{std::move(*view), std::move(*operate)};
  if (tokens.is_empty()) return refuse(file, "no token; expected view = [\"...\"] or operate = [\"...\"]");
  return tokens;
}

Access::Access(Tokens tokens, std::vector<std::string> origins)
    : tokens_(std::move(tokens)), origins_(std::move(origins)) {}

std::variant<Role, Refusal> Access::admit(const Visit& visit) const {
  if (!is_origin_good(visit)) {
    return Refusal{403,
                   fmt::format("origin '{:.80}' is not allowed (--allow-origin adds one)", visit.origin)};
  }
  if (tokens_.is_empty()) {
    if (!is_loopback_name(visit.host))
      return Refusal{403, fmt::format("host '{:.80}' is not a name of this machine's loopback", visit.host)};
    return Role::kOperate;
  }
  constexpr std::string_view kBearer = "Bearer ";
  std::string_view given = visit.query_token;
  if (visit.authorization.starts_with(kBearer))
    given = std::string_view(visit.authorization).substr(kBearer.size());
  if (given.empty()) return Refusal{401, "a token is needed"};
  if (const auto role = role_of(given)) return *role;
  return Refusal{401, "the token is not known"};
}

std::optional<Role> Access::role_of(std::string_view token) const {
  if (!is_token(token)) return std::nullopt;
  const bool operates = is_among(tokens_.operate, token);
  const bool views = is_among(tokens_.view, token);
  if (operates) return Role::kOperate;
  return views ? std::optional(Role::kView) : std::nullopt;
}

bool Access::knows(std::string_view token) const { return role_of(token).has_value(); }

bool Access::is_origin_good(const Visit& visit) const {
  if (visit.origin.empty()) return true;
  if (visit.origin == (visit.is_tls ? "https://" : "http://") + visit.host) return true;
  return std::any_of(origins_.begin(), origins_.end(),
                     [&](const auto& allowed) { return allowed == "*" || allowed == visit.origin; });
}

bool is_loopback_name(std::string_view host) {
  const std::string_view name = without_port(host);
  if (name == "localhost" || name == "[::1]") return true;
  return name.starts_with("127.") &&
         std::all_of(name.begin(), name.end(), [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

bool is_same_secret(std::string_view a, std::string_view b) {
  using Digest = std::array<unsigned char, SHA256_DIGEST_LENGTH>;
  const auto digest = [](std::string_view text) {
    Digest made{};
    SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), made.data());
    return made;
  };
  const Digest of_a = digest(a);
  const Digest of_b = digest(b);
  return CRYPTO_memcmp(of_a.data(), of_b.data(), of_a.size()) == 0;
}

std::string cookie_value(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const auto end = std::min(header.find(';'), header.size());
    std::string_view pair = header.substr(0, end);
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    const auto equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name)
      return std::string(pair.substr(equals + 1));
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return {};
}

std::string query_value(std::string_view target, std::string_view name) {
  const auto question = target.find('?');
  if (question == std::string_view::npos) return {};
  std::string_view query = target.substr(question + 1);
  while (!query.empty()) {
    const auto end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    const auto equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name)
      return percent_decoded(pair.substr(equals + 1));
    query.remove_prefix(std::min(end + 1, query.size()));
  }
  return {};
}

}  // namespace tonus::dashboard
