#include "services/core/text.hpp"

#include <gtest/gtest.h>

namespace tonus {
namespace {

const std::string kReplaced = "\xEF\xBF\xBD";

TEST(Text, KnowsUtf8) {
  for (const char* good : {"", "a", "Zoë", "山田", "\xF0\x9F\x92\xAA", "\xED\x9F\xBF", "\xF4\x8F\xBF\xBF"})
    EXPECT_TRUE(is_utf8(good)) << good;
  // Table 3-7 of the Unicode standard: what may not begin or follow.
  for (const char* bad : {"\xFF", "\x80", "\xC0\xAF", "\xC3", "a\xE5\xB1", "\xE0\x80\xAF", "\xED\xA0\x80",
                          "\xF0\x80\x80\x80", "\xF4\x90\x80\x80", "\xF8\x88\x80\x80\x80", "M\xFCller"})
    EXPECT_FALSE(is_utf8(bad)) << bad;
}

TEST(Text, ReplacesWhatIsNotUtf8AndKeepsTheRest) {
  EXPECT_EQ(as_utf8("M\xFCller 山"), "M" + kReplaced + "ller 山");
  EXPECT_EQ(as_utf8("\xE5\xB1"), kReplaced + kReplaced);
  EXPECT_TRUE(is_utf8(as_utf8(std::string("\x80\xFF\xC0\xF4\xE5\xB1\xB1\xE5", 8))));
}

TEST(Text, ShowsOneLineThatSteersNoTerminal) {
  EXPECT_EQ(shown("P 01, Zoë"), "P 01, Zoë");
  EXPECT_EQ(shown("a\nb\r\x1B[2Jc\x7F"), "a" + kReplaced + "b" + kReplaced + kReplaced + "[2Jc" + kReplaced);
  EXPECT_EQ(shown("\xC2\x9B"
                  "31m"),
            kReplaced + "31m");  // the C1 form of ESC [
  EXPECT_EQ(shown("a\xE2\x80\xAE"
                  "b"),
            "a" + kReplaced + "b");  // right to left override
  EXPECT_EQ(shown("a\xE2\x80\xA8"
                  "b"),
            "a" + kReplaced + "b");  // line separator
}

TEST(MaskedText, IsAsLongAsBeforeAndHasNothingThatSteersATerminal) {
  EXPECT_EQ(masked("P 01, Zo\xC3\xAB \xE5\xB1\xB1", TextKind::kLine), "P 01, Zo\xC3\xAB \xE5\xB1\xB1");
  EXPECT_EQ(masked("M\xFCller\n\x1B[2J\xE2\x80\xAE"
                   "x",
                   TextKind::kLine),
            "M?ller ?[2J???x");
  EXPECT_EQ(masked("a = 1\n\tb\r\n\x07\xC2\x9B", TextKind::kFile), "a = 1\n\tb\r\n???");
  EXPECT_EQ(masked(std::string("a\0b", 3), TextKind::kFile), "a?b");
  EXPECT_EQ(masked("\xE5\xB1", TextKind::kLine), "??");
}

TEST(CellText, IsNoFormulaForASpreadsheet) {
  for (const char* formula : {"=1+1", "+1", "-1", "@SUM(A1)", "\tx", "\rx"})
    EXPECT_EQ(as_cell(formula), std::string("'") + formula);
  for (const char* text : {"", "P-01", "a=b", "'=1"}) EXPECT_EQ(as_cell(text), text);
}

}  // namespace
}  // namespace tonus
