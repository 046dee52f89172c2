// The program `keypose studio`: serves the studio's page for one project.
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <thread>

#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
#include "studio/project/known_projects.h"
#include "studio/runs/children.h"
#include "studio/server/server.h"

namespace keypose::studio {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string folder;
  std::optional<int> port;
  bool no_browser = false;
};

/// The project's folder: the given one, or the nearest parent with a pipeline.yaml, or this one if
/// it is empty and nobody's home. Else none: the page shows which there are.
fs::path FolderOf(const std::string& given) {
  const fs::path start =
      fs::absolute(given.empty() ? "." : pipeline::WithHome(given)).lexically_normal();
  if (!fs::is_directory(start))
    throw UsageError(fmt::format("-C {}: it is not a folder; make it first", start.string()));
  const fs::path clean = start.has_filename() ? start : start.parent_path();
  if (!given.empty()) return FolderToOpen(clean.string());
  for (fs::path folder = clean; folder != folder.root_path(); folder = folder.parent_path())
    if (fs::is_regular_file(folder / "pipeline.yaml")) return folder;
  std::error_code none;
  if (clean == fs::path(pipeline::WithHome("~"))) return {};
  const bool is_for_it = fs::is_empty(clean, none) || fs::exists(clean / "armature");
  return is_for_it && !none ? clean : fs::path();
}

/// Where the page makes new projects: here, but neither among the files of a home folder nor within
/// a project, which they stand beside.
fs::path NewProjects() {
  const fs::path home = pipeline::WithHome("~");
  fs::path here = fs::current_path();
  for (fs::path folder = here; folder != folder.root_path(); folder = folder.parent_path())
    if (fs::exists(folder / "pipeline.yaml")) here = folder.parent_path();
  return here == home || here == "/" ? home / "Keypose" : here;
}

/// Opens the person's browser, if there is a desktop.
void OpenBrowser(const std::string& address) {
  const bool desktop = getenv("DISPLAY") || getenv("WAYLAND_DISPLAY");
  const char* const program = "/usr/bin/xdg-open";
  if (!desktop || access(program, X_OK) != 0) return;
  // It may itself become the browser, for as long as that is open.
  LetGo({program, address}, "/");
}

/// Counts up when the studio shall end. A handler may do little more than write to it.
int stop_event = -1;

void AskToStop(int) { eventfd_write(stop_event, 1); }

/// Ctrl-C, `kill`, or the end of the terminal. A handler and not sigwait: libraries have threads of
/// their own, which would get the signal unblocked and end the program.
void HandleSignals() {
  stop_event = eventfd(0, EFD_CLOEXEC);
  struct sigaction action = {};
  action.sa_handler = AskToStop;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
}

/// Waits for the end; the Enter key meanwhile prints an address for another browser.
std::thread StopWhenAsked(StudioServer& server,
                          const std::function<void(const std::string&)>& say) {
  return std::thread([&server, say] {
    pollfd both[2] = {{stop_event, POLLIN, 0}, {isatty(0) ? 0 : -1, POLLIN, 0}};
    for (;;) {
      if (poll(both, 2, -1) < 0 && errno != EINTR) break;
      if (both[0].revents) break;
      char typed[256];
      if (!both[1].revents) continue;
      if (read(0, typed, sizeof typed) > 0)
        say(server.NewAddress());
      else
        both[1].fd = -1;  // its terminal is gone
    }
    server.Stop();
  });
}

void Say(const std::string& address) {
  fmt::print("{}\n", address);
  std::fflush(stdout);
}

/// Whoever starts it twice without a project, as from the menu of applications, comes to the first.
bool OpensRunning(const Options& options, const fs::path& folder) {
  if (!folder.empty() || options.port) return false;
  const std::string address = AddressOfRunning();
  if (address.empty()) return false;
  Say(address);
  if (!options.no_browser) OpenBrowser(address);
  return true;
}

ExitCode Serve(const Options& options) {
  const fs::path folder = FolderOf(options.folder);
  if (OpensRunning(options, folder)) return ExitCode::kOk;
  HandleSignals();
  StudioServer server({folder, NewProjects(), options.port, &PageFiles()});
  if (folder.empty()) server.TellOthers();
  Say(server.address());
  server.OnAsked(Say);
  server.OnEnd([] { eventfd_write(stop_event, 1); });
  fmt::print(
      "open it in a browser on this machine; Enter prints an address for another browser, "
      "Ctrl-C ends the studio\n");
  std::fflush(stdout);
  if (!options.no_browser) OpenBrowser(server.address());
  std::thread stopper = StopWhenAsked(server, Say);
  server.Serve();
  eventfd_write(stop_event, 1);  // the server may have ended by itself
  stopper.join();
  if (server.IsRunning())
    fmt::print("the run goes on; to see or stop it: keypose studio -C {}\n",
               server.folder().string());
  return ExitCode::kOk;
}

int Main(int argc, char** argv) {
  CLI::App app("The studio: photographs, masks, landmarks, timeline and hand-over in a web page.",
               "keypose studio");
  Options options;
  app.add_option("-C,--folder", options.folder,
                 "the project's folder, or an empty one for a new project; default: that in which "
                 "this is, else the page shows all");
  app.add_option("--port", options.port, "0: any; default: 4777, or the next free one")
      ->check(CLI::Range(0, 65535));
  app.add_flag("--no-browser", options.no_browser, "only print the address");
  try {
    app.parse(argc, argv);
    return static_cast<int>(Serve(options));
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "keypose: error: {}; see `keypose studio --help`\n", error.what());
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    fmt::print(stderr, "keypose: error: {}\n", error.what());
    return static_cast<int>(error.code());
  }
}

}  // namespace
}  // namespace keypose::studio

int main(int argc, char** argv) { return keypose::studio::Main(argc, argv); }
