#include "analysis_service/report/table.hpp"

#include <gtest/gtest.h>

namespace tonus::report {
namespace {

Table example() { return {"t", "A < B", "", {"name", "value, kg"}, {{"", "1.5"}, {"say \"so\"", "2 & 3"}}}; }

TEST(Table, IsWrittenAsCsvWithQuotesWhereTheyAreNeeded) {
  EXPECT_EQ(as_csv(example()), "name,\"value, kg\"\r\n,1.5\r\n\"say \"\"so\"\"\",2 & 3\r\n");
}

TEST(Table, IsSafeAsHtml) {
  const std::string html = as_html(example());
  EXPECT_NE(html.find("<h3>A &lt; B</h3>"), std::string::npos);
  EXPECT_NE(html.find("<td>2 &amp; 3</td>"), std::string::npos);
  EXPECT_EQ(html.find("say \"so\""), std::string::npos);
}

}  // namespace
}  // namespace tonus::report
