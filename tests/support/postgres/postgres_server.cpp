#include "tests/support/postgres/postgres_server.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <pwd.h>
#include <sstream>
#include <unistd.h>
#include <vector>

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kOldest = 15;
constexpr std::chrono::seconds kPatience{60};

/// Folder of the newest server's programs; empty: there is none.
fs::path find_programs() {
  int newest = kOldest - 1;
  fs::path found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator("/usr/lib/postgresql", none)) {
    const int version = std::atoi(entry.path().filename().c_str());
    if (version <= newest || !fs::exists(entry.path() / "bin" / "postgres")) continue;
    newest = version;
    found = entry.path() / "bin";
  }
  return found;
}

/// Whom the server runs as in the place of root.
const passwd* other_user() {
  for (const char* name : {"postgres", "nobody"}) {
    if (const passwd* user = ::getpwnam(name)) return user;
  }
  return nullptr;
}

/// The words that run a program as that user, who goes down with the test.
std::vector<std::string> as_other_user(const std::vector<std::string>& words) {
  if (::geteuid() != 0) return words;
  const passwd* user = other_user();
  std::vector<std::string> all{"/usr/bin/setpriv", "--reuid=" + std::to_string(user->pw_uid),
                               "--regid=" + std::to_string(user->pw_gid), "--clear-groups",
                               "--pdeathsig=QUIT"};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace

PostgresServer::PostgresServer(fs::path programs) : programs_(std::move(programs)) {
  if (::geteuid() != 0) return;
  const passwd* user = other_user();
  fs::permissions(folder_.path(), fs::perms::owner_all | fs::perms::group_all | fs::perms::others_all);
  fs::create_directory(data());
  if (::chown(data().c_str(), user->pw_uid, user->pw_gid) != 0) process_.reset();  // initdb says so
}

Result<void> PostgresServer::run(const std::string& program, std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), (programs_ / program).string());
  const auto words = as_other_user(arguments);
  Process process(words[0], {words.begin() + 1, words.end()}, folder_ / (program + ".log"));
  if (process.wait(kPatience) == 0) return {};
  return fail(ErrorCode::kUnavailable, program + ": " + process.output());
}

Result<std::unique_ptr<PostgresServer>> PostgresServer::start() {
  const fs::path programs = find_programs();
  if (programs.empty())
    return fail(ErrorCode::kNotFound,
                "no PostgreSQL 15 or newer in /usr/lib/postgresql (package postgresql-15)");
  if (::geteuid() == 0 && other_user() == nullptr)
    return fail(ErrorCode::kNotFound, "no user 'postgres' or 'nobody' to run a server as");
  std::unique_ptr<PostgresServer> server(new PostgresServer(programs));
  auto made = server->run("initdb", {"-D", server->data().string(), "-U", "tonus", "--auth=trust",
                                     "--no-sync", "--encoding=UTF8", "--locale=C"});
  if (!made) return made.error();
  if (auto started = server->restart(); !started) return started.error();
  return server;
}

Result<void> PostgresServer::restart() {
  fs::remove(data() / "postmaster.pid");
  const auto words =
      as_other_user({(programs_ / "postgres").string(), "-D", data().string(), "-k", folder_.path().string(),
                     "-c", "listen_addresses=", "-c", "shared_buffers=16MB", "-c", "max_connections=20",
                     // In the server's folder, which goes away with it, also when it is killed.
                     "-c", "dynamic_shared_memory_type=mmap"});
  process_ = std::make_unique<Process>(words[0], std::vector<std::string>{words.begin() + 1, words.end()},
                                       folder_ / "server.log");
  if (process_->wait_for_output("ready to accept connections", kPatience)) return {};
  return fail(ErrorCode::kUnavailable, "postgres: " + process_->output());
}

void PostgresServer::kill() {
  // Its processes are each the leader of a group: they are found as children.
  std::vector<pid_t> all{process_->id()};
  std::ifstream children("/proc/" + std::to_string(process_->id()) + "/task/" +
                         std::to_string(process_->id()) + "/children");
  for (pid_t child = 0; children >> child;) all.push_back(child);
  for (const pid_t id : all) ::kill(id, SIGKILL);
  (void)process_->wait(kPatience);
}

Result<std::string> PostgresServer::make_database() {
  const std::string name = "study_" + std::to_string(++databases_);
  if (auto made = run("createdb", {"-h", folder_.path().string(), "-U", "tonus", name}); !made)
    return made.error();
  return "postgresql://tonus@/" + name + "?host=" + folder_.path().string();
}

}  // namespace tonus::testing
