#include "services/protocol/protocol.hpp"

#include <spdlog/fmt/fmt.h>

namespace tonus::protocol {

const char* kind_name(ProtocolKind kind) {
  switch (kind) {
    case ProtocolKind::kUnloaded:
      return "unloaded";
    case ProtocolKind::kLoaded:
      return "loaded";
    case ProtocolKind::kInstruction:
      return "instruction";
    case ProtocolKind::kRecording:
      return "recording";
    case ProtocolKind::kStudy:
      return "study";
  }
  return "unknown";
}

const char* axis_name(BiasAxis axis) {
  switch (axis) {
    case BiasAxis::kNone:
      return "none";
    case BiasAxis::kMajorPlus:
      return "+major";
    case BiasAxis::kMajorMinus:
      return "-major";
    case BiasAxis::kMinorPlus:
      return "+minor";
    case BiasAxis::kMinorMinus:
      return "-minor";
  }
  return "unknown";
}

std::vector<std::string> methods_needed(const Protocol& protocol) {
  std::vector<std::string> methods;
  if (protocol.bias) methods.push_back(protocol.bias->method);
  if (protocol.stop_when && (methods.empty() || methods.front() != protocol.stop_when->method))
    methods.push_back(protocol.stop_when->method);
  return methods;
}

Error refuse_value(const Protocol& protocol, const std::string& key, const std::string& value,
                   const std::string& expected) {
  const auto line = protocol.lines.find(key);
  const std::string place =
      line == protocol.lines.end() ? protocol.source : fmt::format("{}:{}", protocol.source, line->second);
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("{}: {}: {} is not allowed; expected {}", place, key, value, expected));
}

}  // namespace tonus::protocol
