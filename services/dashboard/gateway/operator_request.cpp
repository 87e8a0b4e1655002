#include "services/dashboard/gateway/operator_request.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <spdlog/fmt/fmt.h>

#include "services/contract/review.hpp"
#include "services/contract/subject.hpp"
#include "services/contract/subject_json.hpp"
#include "services/core/clock.hpp"
#include "services/core/text.hpp"

namespace tonus::dashboard {
namespace {

using nlohmann::json;

template <typename Request>
struct Named {
  std::string_view name;
  Request request;
};

constexpr std::array<Named<v1::SessionRequest>, 6> kSessionRequests{
    {{"start", v1::SESSION_START},
     {"pause", v1::SESSION_PAUSE},
     {"resume", v1::SESSION_RESUME},
     {"abort", v1::SESSION_ABORT},
     {"reject_trial", v1::SESSION_REJECT_TRIAL},
     {"note", v1::SESSION_NOTE}}};
constexpr std::array<Named<v1::RigRequest>, 3> kRigRequests{{{"emergency_stop", v1::RIG_EMERGENCY_STOP},
                                                             {"clear_fault", v1::RIG_CLEAR_FAULT},
                                                             {"abort_trial", v1::RIG_ABORT_TRIAL}}};
constexpr char kEmergencyStop[] = "emergency_stop";
constexpr std::size_t kLongestProtocol = 50000;  // what a session command has room for
constexpr std::size_t kLongestSubject = 128;
constexpr std::size_t kLongestName = 160;  // bytes: 40 characters
constexpr std::size_t kLongestPage = 16;

Error wrong(const std::string& text) { return fail(ErrorCode::kInvalidArgument, text); }

template <typename List>
auto find(const List& list, std::string_view name) {
  using Request = decltype(list.front().request);
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& n) { return n.name == name; });
  return found == list.end() ? std::optional<Request>{} : std::optional<Request>{found->request};
}

Result<std::string> text_in(const json& object, const char* field, std::size_t longest) {
  const auto found = object.find(field);
  if (found == object.end()) return std::string();
  if (!found->is_string()) return wrong(fmt::format("\"{}\" must be a text", field));
  auto text = found->get<std::string>();
  if (text.size() > longest || text.find('\0') != std::string::npos) {
    return wrong(fmt::format("\"{}\" has {} bytes; at most {}, none of them zero, are allowed", field,
                             text.size(), longest));
  }
  return text;
}

Result<Id> id_in(const json& object, const char* field) {
  const auto text = text_in(object, field, 64);
  if (!text) return text.error();
  if (text->empty()) return kNoId;
  auto id = id_from_hex(*text);
  if (!id) return wrong(fmt::format("\"{}\" must be 32 hexadecimal digits", field));
  return *id;
}

/// Bytes of a name in UTF-8 that can be part of a line: no control character, and none of what separates its
/// parts.
bool is_name(std::string_view name) {
  return std::none_of(name.begin(), name.end(),
                      [](unsigned char c) { return c < 0x20 || c == 0x7f || c == ';' || c == ','; });
}

bool is_page(std::string_view page) {
  return std::all_of(page.begin(), page.end(), [](char c) { return c >= 'a' && c <= 'z'; });
}

/// Who asks, as it is recorded.
Result<std::string> requested_by(const json& object, const Asker& asker, bool is_stop) {
  const auto by = text_in(object, "by", kLongestName);
  if (!by) return by.error();
  if (!is_name(*by)) return wrong("\"by\" must be a name without commas, semicolons and control characters");
  const auto page = text_in(object, "page", kLongestPage);
  if (!page) return page.error();
  if (!is_page(*page)) return wrong("\"page\" must have lower-case letters only");
  std::string text = by->empty() ? asker.name : fmt::format("{}, {}", *by, asker.name);
  if (!page->empty()) text += " on " + *page;
  if (is_stop && asker.utc_ns != 0) text += fmt::format(" at {} UTC", iso8601(asker.utc_ns).substr(11, 8));
  return text;
}

/// A line for a person: no control characters, nothing that turns the direction of what follows.
Result<std::string> line_in(const json& object, const char* field, std::size_t longest) {
  auto text = text_in(object, field, longest);
  if (text && shown(*text) != *text)
    return wrong(fmt::format("\"{}\" must be one line without control characters", field));
  return text;
}

Result<bool> flag_in(const json& object, const char* field) {
  const auto found = object.find(field);
  if (found == object.end()) return false;
  if (!found->is_boolean()) return wrong(fmt::format("\"{}\" must be true or false", field));
  return found->get<bool>();
}

/// Of a start: who the subject is, and what the session belongs to.
Result<void> add_start(const json& object, v1::SessionCommand& command) {
  TONUS_TRY_ASSIGN(const auto study, line_in(object, "study", kLongestSubject));
  TONUS_TRY_ASSIGN(const bool is_pilot, flag_in(object, "is_pilot"));
  if (object.contains("subject_facts")) {
    TONUS_TRY_ASSIGN(const auto facts, contract::subject_facts_of(object.at("subject_facts")));
    command.subject_facts(facts);
  }
  command.study(study);
  command.is_pilot(is_pilot);
  return {};
}

/// Of a rejection or a note: of which trial, and what is said.
Result<void> add_remark(const json& object, v1::SessionCommand& command) {
  const bool is_note = command.request() == v1::SESSION_NOTE;
  TONUS_TRY_ASSIGN(const auto trial, id_in(object, "trial_id"));
  if (!is_note && trial == kNoId) return wrong("\"trial_id\" must name the trial that is rejected");
  TONUS_TRY_ASSIGN(const auto text, line_in(object, "text", contract::kOperatorTextMost));
  if (text.find_first_not_of(' ') == std::string::npos) {
    return wrong(is_note ? "\"text\" must say what is noted" : "\"text\" must say why the trial is rejected");
  }
  TONUS_TRY_ASSIGN(auto kind, text_in(object, "note_kind", 16));
  if (kind.empty()) kind = "note";
  if (const auto good = contract::check_note_kind(kind); is_note && !good) return wrong(good.error().message);
  command.trial_id(trial);
  command.text(text);
  if (is_note) command.note_kind(kind);
  return {};
}

Result<OperatorCommand> session_command(const json& object, v1::SessionRequest request, const Id& id,
                                        const Asker& asker) {
  v1::SessionCommand command;
  const auto session = id_in(object, "session_id");
  if (!session) return session.error();
  const auto protocol = text_in(object, "protocol_toml", kLongestProtocol);
  if (!protocol) return protocol.error();
  const auto subject = text_in(object, "subject", kLongestSubject);
  if (!subject) return subject.error();
  if (object.contains("seed")) {
    if (!object.at("seed").is_number_unsigned()) return wrong("\"seed\" must be a whole number from 0");
    command.seed(object.at("seed").get<std::uint64_t>());
  }
  command.session_id(*session);
  command.request_id(id);
  command.request(request);
  command.protocol_toml(*protocol);
  command.subject(*subject);
  command.subject_facts(contract::unknown_subject());
  command.requested_by(asker.name);
  if (request == v1::SESSION_START) TONUS_TRY(add_start(object, command));
  if (request == v1::SESSION_REJECT_TRIAL || request == v1::SESSION_NOTE)
    TONUS_TRY(add_remark(object, command));
  return OperatorCommand(std::move(command));
}

Result<OperatorCommand> rig_command(const json& object, v1::RigRequest request, const Id& id,
                                    const Asker& asker) {
  const auto trial = id_in(object, "trial_id");
  if (!trial) return trial.error();
  v1::RigCommand command;
  command.rig_id(asker.rig);
  command.request_id(id);
  command.request(request);
  command.trial_id(*trial);
  if (request == v1::RIG_CLEAR_FAULT) {
    // Of the hold that the operator has seen: another one is not cleared by it.
    const auto number = object.find("hold_number");
    if (number == object.end() || !number->is_number_unsigned() || number->get<std::uint64_t>() > UINT32_MAX)
      return wrong("\"hold_number\" must be the number of the hold that the rig's state shows");
    command.hold_number(number->get<std::uint32_t>());
  }
  command.requested_by(asker.name);
  return OperatorCommand(std::move(command));
}

}  // namespace

bool is_allowed(Role role, std::string_view request_name) {
  return role == Role::kOperate || request_name == kEmergencyStop;
}

Result<OperatorRequest> parse_request(std::string_view text, const Asker& asker, Id& id, std::string& name) {
  const json object = json::parse(text, nullptr, false);
  if (object.is_discarded() || !object.is_object()) return wrong("a request must be one JSON object");
  const auto given_id = id_in(object, "request_id");
  if (!given_id) return given_id.error();
  if (*given_id == kNoId) return wrong("\"request_id\" is missing; expected 32 hexadecimal digits");
  id = *given_id;
  const auto given_name = text_in(object, "request", 32);
  if (!given_name) return given_name.error();
  name = *given_name;
  const auto session_request = find(kSessionRequests, name);
  const auto rig_request = find(kRigRequests, name);
  if (!session_request && !rig_request) {
    return wrong(
        fmt::format("request: \"{}\" is not allowed; expected start, pause, resume, abort, "
                    "reject_trial, note, emergency_stop, clear_fault or abort_trial",
                    name));
  }
  if (!is_allowed(asker.role, name)) {
    return wrong(fmt::format("the role {} may not ask for {}; only for {}", role_name(asker.role), name,
                             kEmergencyStop));
  }
  auto by = requested_by(object, asker, name == kEmergencyStop);
  // What is wrong with a name stops no stop.
  if (!by && name != kEmergencyStop) return by.error();
  const Asker named{asker.role, by ? *by : asker.name, asker.rig, asker.utc_ns};
  auto command = session_request ? session_command(object, *session_request, id, named)
                                 : rig_command(object, *rig_request, id, named);
  if (!command) return command.error();
  return OperatorRequest{id, name, named.name, std::move(*command)};
}

std::string reply_text(const OperatorReply& reply) {
  return json{{"request_id", to_hex(reply.id)},
              {"request", reply.name},
              {"is_done", reply.is_done},
              {"message", reply.message},
              {"requested_by", reply.requested_by}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace tonus::dashboard
