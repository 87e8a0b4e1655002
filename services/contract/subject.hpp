#pragma once

#include <cstddef>
#include <string_view>

#include "services/core/result.hpp"

#include <idl/session.h>

/// What may be said of the people in a session, checked by whoever takes it from a person or from a message:
/// the command line, the gateway, the scheduler and the import. Errors (kInvalidArgument) are lines of the
/// form "age: 130 is not allowed; expected ...", whose first word is the option and key of the value.
namespace tonus::contract {

/// A subject of whom nothing is known: empty texts, numbers that are not finite.
[[nodiscard]] v1::SubjectFacts unknown_subject();

/// Bytes of a name: of a subject, an operator, a study.
inline constexpr std::size_t kNameMost = 80;
/// Years. An older person could be known by the age: 89 stands for 89 and more.
inline constexpr double kAgeMost = 89.0;

/// A subject's name has 1 to kNameMost bytes on one line, after "sub-" if it begins so; every such name has a
/// label in BIDS (recording::to_label()).
[[nodiscard]] Result<void> check_subject_name(std::string_view name);

/// What is known of a subject is in range: numbers that are not finite, and empty texts, are not known.
[[nodiscard]] Result<void> check_subject_facts(const v1::SubjectFacts& facts);

/// The name of an operator or a study: empty where there is none, else as a subject's. `what` names it in the
/// message.
[[nodiscard]] Result<void> check_name(std::string_view what, std::string_view name);

/// Everything that a request to start a session says of people: subject, facts, operator (requested_by),
/// study.
[[nodiscard]] Result<void> check_people(const v1::SessionCommand& start);

/// Puts what `newer` knows over what `facts` has.
void update_facts(v1::SubjectFacts& facts, const v1::SubjectFacts& newer);

/// True where something is known.
[[nodiscard]] bool is_anything_known(const v1::SubjectFacts& facts);

}  // namespace tonus::contract
