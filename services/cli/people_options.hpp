#pragma once

#include <string>
#include <vector>

#include "services/core/result.hpp"

#include <idl/session.h>

namespace CLI {
class App;
}  // namespace CLI

namespace tonus::cli {

/// Who is measured, by whom, and for what: the options of `tonus run`.
struct PeopleOptions {
  v1::SubjectFacts facts;  ///< But for the pairs below.
  std::vector<double> link_lengths;
  std::vector<double> circumferences;
  std::vector<double> shoulder;
  std::string operator_name;
  std::string study;
  bool is_pilot = false;

  PeopleOptions();
};

void add_people_options(CLI::App& command, PeopleOptions& people);

/// Puts them into a request to start a session of this subject. kInvalidArgument: contract::check_people().
[[nodiscard]] Result<void> put_people(const PeopleOptions& people, const std::string& subject,
                                      v1::SessionCommand& start);

}  // namespace tonus::cli
