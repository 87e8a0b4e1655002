#include "services/config/checked_table.hpp"

#include <functional>
#include <gtest/gtest.h>

#include "services/config/toml_text.hpp"

namespace tonus::config {
namespace {

/// What reading the text with `read` reports; empty: nothing.
std::string problem_of(std::string_view text, const std::function<void(CheckedTable&)>& read) {
  const auto table = parse_toml(text, "a.toml");
  if (!table) return table.error().message;
  Findings findings{"a.toml", {}, {}};
  CheckedTable root(*table, "", 0, findings);
  read(root);
  root.finish();
  return findings.problem.value_or("");
}

TEST(CheckedTable, KeepsTheTargetsValueWhereTheKeyIsAbsentOrRefused) {
  double number = 3.0;
  unsigned count = 4;
  std::array<unsigned, 2> both{5, 6};
  const auto read = [&](CheckedTable& table) {
    table.number("number", number, 0.0, 10.0);
    table.count("count", count, 1, 10);
    table.one_or_two("both", both, 0, 255, false);
  };
  EXPECT_EQ(problem_of("", read), "");
  EXPECT_EQ(problem_of("number = 11\ncount = 0\nboth = [1, 2, 3]", read),
            "a.toml:1: number: 11 is not allowed; expected 0 to 10");
  EXPECT_EQ(number, 3.0);
  EXPECT_EQ(count, 4U);
  EXPECT_EQ(both, (std::array<unsigned, 2>{5, 6}));
  EXPECT_EQ(problem_of("number = 1\ncount = 2\nboth = 7", read), "");
  EXPECT_EQ(number, 1.0);
  EXPECT_EQ(count, 2U);
  EXPECT_EQ(both, (std::array<unsigned, 2>{7, 7}));
}

TEST(CheckedTable, ReportsTheFirstProblemAtItsLine) {
  const auto read = [](CheckedTable& table) {
    (void)table.whole("first", 1, 2);
    bool second = false;
    table.flag("second", second);
  };
  EXPECT_EQ(problem_of("\nsecond = 1\nfirst = 3\n", read),
            "a.toml:3: first: 3 is not allowed; expected a whole number, 1 to 2");
  EXPECT_EQ(problem_of("", read), "a.toml: first is missing; expected a whole number, 1 to 2");
}

TEST(CheckedTable, SuggestsTheKeyThatWasProbablyMeant) {
  const auto read = [](CheckedTable& table) {
    for (const char* key : {"amplitude_m", "sets"}) (void)table.has(key);
  };
  EXPECT_EQ(problem_of("amplitud_m = 1", read),
            "a.toml:1: amplitud_m: unknown key; did you mean amplitude_m?");
  EXPECT_EQ(problem_of("speed = 1", read), "a.toml:1: speed: unknown key; expected one of amplitude_m, sets");
}

TEST(CheckedTable, TakesAnAbsentOptionalTableAsEmpty) {
  double number = 3.0;
  const auto read = [&](CheckedTable& table) {
    CheckedTable inner = table.optional_table("inner");
    inner.number("number", number, 0.0, 10.0);
    inner.finish();
  };
  EXPECT_EQ(problem_of("", read), "");
  EXPECT_EQ(problem_of("[inner]\nnumber = 4", read), "");
  EXPECT_EQ(number, 4.0);
  EXPECT_EQ(problem_of("inner = 4", read), "a.toml:1: inner: 4 is not allowed; expected a table [inner]");
}

TEST(TomlText, NamesTheLineOfWhatIsNoToml) {
  EXPECT_EQ(parse_toml("a = 1\nb = = 2", "a.toml").error().message.substr(0, 20), "a.toml:2: not TOML: ");
}

TEST(TomlText, RefusesAKeySoDeepThatTheParserWouldExhaustTheStack) {
  std::string text;
  for (int i = 0; i < 200'000; ++i) text += "a.";
  EXPECT_FALSE(parse_toml(text + "a = 1", "a.toml"));
}

}  // namespace
}  // namespace tonus::config
