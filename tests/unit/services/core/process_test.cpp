#include "services/core/process.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/core/file_descriptor.hpp"
#include "services/core/text_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

class ProcessTest : public ::testing::Test {
 protected:
  /// What a child prints; its end goes to `end_`.
  std::string printed(const std::vector<std::string>& words, ProcessOptions options = {}) {
    const auto file = folder_ / "output";
    const FileDescriptor output(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    options.output = output.get();
    auto end = run_process(words, options);
    if (!end) return end.error().message;
    end_ = *end;
    return read_text_file(file).value();
  }

  testing::TemporaryFolder folder_;
  ProcessEnd end_;
};

TEST_F(ProcessTest, PassesArgumentsToTheProgramAsTheyAre) {
  EXPECT_EQ(printed({"printf", "%s|", "two words", "$HOME", "'", "*"}), "two words|$HOME|'|*|");
  EXPECT_TRUE(end_.is_success());
}

TEST_F(ProcessTest, TellsExitCodesFromSignals) {
  (void)printed({"sh", "-c", "exit 3"});
  EXPECT_EQ(end_.text(), "ended with exit code 3");
  (void)printed({"sh", "-c", "kill -9 $$"});
  EXPECT_EQ(end_.text(), "was ended by signal 9");
}

TEST_F(ProcessTest, HasItsOwnFolderAndEnvironment) {
  const auto text = printed({"sh", "-c", "pwd; echo $LC_ALL; echo $PATH"},
                            {.output = -1, .folder = folder_ / "", .environment = {"LC_ALL=C.UTF-8"}});
  EXPECT_THAT(text, HasSubstr((folder_ / "").parent_path().filename().string()));
  EXPECT_THAT(text, HasSubstr("\nC.UTF-8\n" + std::string(std::getenv("PATH"))));
}

TEST_F(ProcessTest, StartOfWhatIsNoProgramIsAnErrorThatNamesIt) {
  EXPECT_EQ(printed({"no-such-program"}), "start of no-such-program failed: No such file or directory");
  const auto text = folder_ / "text";
  std::ofstream(text) << "not a program";
  EXPECT_EQ(printed({text.string()}), "start of " + text.string() + " failed: Permission denied");
  std::filesystem::permissions(text, std::filesystem::perms::owner_all);
  EXPECT_EQ(printed({text.string()}), "start of " + text.string() + " failed: Exec format error");
}

TEST_F(ProcessTest, StopEndsAProgramThatIgnoresTheRequestToEnd) {
  auto child = ChildProcess::start({"sh", "-c", "trap '' TERM; while :; do sleep 1; done"}, {});
  ASSERT_TRUE(child) << child.error().message;
  EXPECT_FALSE(child->poll());
  (void)child->stop(0s);
  EXPECT_NE(kill(child->id(), 0), 0);
  child->signal(SIGKILL);  // of a process whose end was seen: does nothing
}

TEST_F(ProcessTest, EndsWithTheProcessThatStartedIt) {
  // A parent between the test and the child: it starts the child, says its id, and is killed.
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  const pid_t parent = fork();
  if (parent == 0) {
    auto child = ChildProcess::start({"sleep", "1000"}, {});
    const pid_t id = child ? child->id() : 0;
    (void)!write(ends[1], &id, sizeof id);
    pause();
    _exit(0);
  }
  pid_t orphan = 0;
  ASSERT_EQ(read(ends[0], &orphan, sizeof orphan), static_cast<ssize_t>(sizeof orphan));
  ASSERT_GT(orphan, 0);
  kill(parent, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(parent, &status, 0), parent);
  ASSERT_EQ(waitpid(orphan, &status, 0), orphan);  // it became this process's child
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
  for (const int end : ends) close(end);
}

TEST(FindProgram, LooksInThePathLikeAShell) {
  EXPECT_TRUE(find_program("sh"));
  EXPECT_FALSE(find_program("no-such-program"));
  EXPECT_FALSE(find_program(""));
  EXPECT_FALSE(find_program("/"));
}

}  // namespace
}  // namespace tonus
