#include "services/recording/participants.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "services/core/json_text.hpp"
#include "services/core/text.hpp"
#include "services/recording/number_text.hpp"
#include "services/recording/table.hpp"

namespace tonus::recording {
namespace {

struct NumberColumn {
  const char* name;
  std::optional<double> Participant::*member;
  const char* description;
  const char* units;
};

constexpr NumberColumn kNumberColumns[] = {
    {"upper_arm_m", &Participant::upper_arm_m, "Length of the upper arm", "m"},
    {"forearm_m", &Participant::forearm_m, "Length of the forearm, elbow to the hand's centre", "m"},
    {"upper_arm_circumference_m", &Participant::upper_arm_circumference_m, "Circumference of the upper arm",
     "m"},
    {"forearm_circumference_m", &Participant::forearm_circumference_m, "Circumference of the forearm", "m"},
    {"age", &Participant::age, "Age", "year"},
    {"height_m", &Participant::height_m, "Body height", "m"},
    {"weight_kg", &Participant::weight_kg, "Body weight", "kg"},
    {"shoulder_x_m", &Participant::shoulder_x_m,
     "Centre of the measured arm's shoulder joint in the robot's frame, x", "m"},
    {"shoulder_y_m", &Participant::shoulder_y_m,
     "Centre of the measured arm's shoulder joint in the robot's frame, y", "m"},
};

struct TextColumn {
  const char* name;
  std::string Participant::*member;
  const char* description;
};

constexpr TextColumn kTextColumns[] = {
    {"handedness", &Participant::handedness, "Handedness as the participant states it"},
    {"sex", &Participant::sex, "Sex as the participant states it"},
    {"measured_arm", &Participant::measured_arm, "The arm that was measured"},
};

template <typename ColumnType>
bool is_known(const std::vector<Participant>& participants, const ColumnType& column) {
  return std::any_of(participants.begin(), participants.end(), [&column](const Participant& participant) {
    return participant.*column.member != decltype(participant.*column.member){};
  });
}

/// An age may be "89+".
Result<std::optional<double>> read_number(const Table& table, std::size_t row, const NumberColumn& column,
                                          Participant& participant) {
  std::string_view cell = table.cell(row, column.name);
  if (column.member == &Participant::age && cell.ends_with('+')) {
    cell.remove_suffix(1);
    if (const auto least = parse_number(cell)) {
      participant.is_age_or_more = true;
      return least;
    }
  }
  return table.number_or_nothing(row, column.name);
}

}  // namespace

Result<std::map<std::string, Participant>> read_participants(const std::filesystem::path& file,
                                                             std::vector<std::string>* left_out) {
  TONUS_TRY_ASSIGN(const auto table, Table::read(file));
  TONUS_TRY(table.require({"participant_id"}));
  std::map<std::string, Participant> participants;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Participant participant;
    participant.id = table.cell(row, "participant_id");
    for (const NumberColumn& column : kNumberColumns) {
      const auto number = read_number(table, row, column, participant);
      if (!number && left_out == nullptr) return number.error();
      if (number) {
        participant.*column.member = *number;
      } else {
        left_out->push_back(number.error().message);
      }
    }
    for (const TextColumn& column : kTextColumns) participant.*column.member = table.text(row, column.name);
    if (!participants.emplace(participant.id, participant).second) {
      return table.refuse(row, "participant_id", "each participant once");
    }
  }
  return participants;
}

std::string participants_text(const std::vector<Participant>& participants) {
  std::string text = "participant_id";
  for (const auto& column : kNumberColumns) {
    if (is_known(participants, column)) text += std::string("\t") + column.name;
  }
  for (const auto& column : kTextColumns) {
    if (is_known(participants, column)) text += std::string("\t") + column.name;
  }
  text += '\n';
  for (const Participant& participant : participants) {
    text += participant.id;
    for (const auto& column : kNumberColumns) {
      if (!is_known(participants, column)) continue;
      text += '\t';
      if (const auto& value = participant.*column.member) {
        append_number(text, *value);
        if (column.member == &Participant::age && participant.is_age_or_more) text += '+';
      } else {
        text += "n/a";
      }
    }
    for (const auto& column : kTextColumns) {
      if (!is_known(participants, column)) continue;
      const std::string& value = participant.*column.member;
      text += '\t' + (value.empty() ? "n/a" : shown(value));
    }
    text += '\n';
  }
  return text;
}

std::string participants_json(const std::vector<Participant>& participants) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& column : kNumberColumns) {
    if (is_known(participants, column))
      json[column.name] = {{"Description", column.description}, {"Units", column.units}};
  }
  for (const auto& column : kTextColumns) {
    if (is_known(participants, column)) json[column.name] = {{"Description", column.description}};
  }
  return json_text(json, 2) + "\n";
}

}  // namespace tonus::recording
