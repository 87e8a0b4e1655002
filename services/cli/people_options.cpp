#include "services/cli/people_options.hpp"

#include <CLI/CLI.hpp>

#include "services/contract/subject.hpp"

namespace tonus::cli {
namespace {

constexpr const char* kGroup = "Subject and study";

/// An option that sets a number of the subject.
void add_number(CLI::App& command, const std::string& name, double& value, const std::string& what) {
  command.add_option(name, value, what)->group(kGroup)->default_str("");
}

void add_pair(CLI::App& command, const std::string& name, std::vector<double>& values,
              const std::string& what) {
  command.add_option(name, values, what)->expected(2)->delimiter(',')->group(kGroup);
}

}  // namespace

PeopleOptions::PeopleOptions() : facts(contract::unknown_subject()) {}

void add_people_options(CLI::App& command, PeopleOptions& people) {
  v1::SubjectFacts& facts = people.facts;
  add_number(command, "--age", facts.age_years(), "of the subject, years; 89 stands for 89 and more");
  command.add_option("--sex", facts.sex(), "of the subject: male, female or other")->group(kGroup);
  command.add_option("--handedness", facts.handedness(), "of the subject: right, left or ambidextrous")
      ->group(kGroup);
  command.add_option("--arm", facts.measured_arm(), "the arm that is measured: right or left")->group(kGroup);
  add_number(command, "--height", facts.height_m(), "of the subject, m");
  add_number(command, "--weight", facts.weight_kg(), "of the subject, kg");
  add_pair(command, "--link-lengths", people.link_lengths,
           "of the upper arm, and of the forearm with the hand to the handle's centre, m");
  add_pair(command, "--circumferences", people.circumferences,
           "of the upper arm and the forearm, where they are widest, m");
  add_pair(command, "--shoulder", people.shoulder,
           "centre of the shoulder joint in the robot's frame, x y, m");
  command.add_option("--operator", people.operator_name, "who runs the session")->group(kGroup);
  command
      .add_option("--study", people.study,
                  "name of the study that the session belongs to (default: a study's own)")
      ->group(kGroup);
  command
      .add_flag("--pilot", people.is_pilot,
                "a rehearsal: marked in the data, and no part of a study's results")
      ->group(kGroup);
}

Result<void> put_people(const PeopleOptions& people, const std::string& subject, v1::SessionCommand& start) {
  v1::SubjectFacts facts = people.facts;
  if (people.link_lengths.size() == 2) facts.link_lengths_m({people.link_lengths[0], people.link_lengths[1]});
  if (people.circumferences.size() == 2)
    facts.circumferences_m({people.circumferences[0], people.circumferences[1]});
  if (people.shoulder.size() == 2) facts.shoulder_m({people.shoulder[0], people.shoulder[1]});
  start.subject(subject);
  start.subject_facts(facts);
  start.requested_by(people.operator_name);
  start.study(people.study);
  start.is_pilot(people.is_pilot);
  return contract::check_people(start);
}

}  // namespace tonus::cli
