// The program `keypose armature`: a puppet of wire, with a sensor on each joint, as an input
// device.
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "armature/armature_commands.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

struct Subcommand {
  const char* name;
  const char* help;
  int (*run)(int argc, char** argv);
};

const std::vector<Subcommand> kSubcommands = {
    {"check", "read a description and its chains, and say what is wrong or what they hold",
     CheckCommand},
    {"simulate", "a controller without hardware, on a pseudo terminal", SimulateCommand},
    {"calibrate", "set the zero position, check it, find gear ratios", CalibrateCommand},
    {"record", "record a puppet frame by frame", RecordCommand},
    {"live", "pose the character while the puppet is moved", LiveCommand},
    {"edit", "change a recorded take, as a new one", EditCommand},
    {"show", "write what a page needs to show a character", ShowCommand},
    {"drafts", "answer what a recorded take would be with some changes", DraftsCommand},
    {"files", "find the puppet's files that a take was recorded with", FilesCommand},
    {"bake", "make an animation's frames from recorded curves", BakeCommand},
    {"example", "write the files of a theropod with 74 sensors", ExampleCommand},
};

void PrintHelp(std::FILE* out) {
  std::fputs("Reads a physical armature with a sensor on each joint.\n\n", out);
  std::fputs("Usage: keypose armature SUBCOMMAND ... (each has --help)\n\n", out);
  for (const Subcommand& command : kSubcommands)
    std::fprintf(out, "  %-10s %s\n", command.name, command.help);
}

[[noreturn]] void RefuseWord(const std::string& word) {
  std::vector<std::string> names;
  for (const Subcommand& command : kSubcommands) names.push_back(command.name);
  throw UsageError("armature: '" + word + "' is not a subcommand; did you mean '" +
                   NearestWord(word, names) + "'? `keypose armature --help` lists all");
}

int Dispatch(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "--help";
  if (word == "--help" || word == "-h") {
    PrintHelp(argc > 1 ? stdout : stderr);
    return static_cast<int>(argc > 1 ? ExitCode::kOk : ExitCode::kUsage);
  }
  for (const Subcommand& command : kSubcommands) {
    if (word != command.name) continue;
    argv[1] = argv[0];
    return command.run(argc - 1, argv + 1);
  }
  RefuseWord(word);
}

int Main(int argc, char** argv) {
  try {
    return Dispatch(argc, argv);
  } catch (const Error& error) {
    std::fflush(stdout);
    std::fprintf(stderr, "keypose: %s%s\n",
                 error.code() == ExitCode::kInterrupted ? "" : "error: ", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "keypose: a bug: %s\nplease report it, with your command\n", error.what());
    return static_cast<int>(ExitCode::kBug);
  }
}

}  // namespace
}  // namespace keypose::armature

int main(int argc, char** argv) { return keypose::armature::Main(argc, argv); }
