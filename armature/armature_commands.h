// The subcommands of `keypose armature`; each in a file of its own.
#pragma once

namespace keypose::armature {

/// Each gets the command line without the words before the subcommand's own (argv[0] is the
/// program), and returns the exit code. Errors are thrown (core/values/errors.h).
int CheckCommand(int argc, char** argv);
int SimulateCommand(int argc, char** argv);
int CalibrateCommand(int argc, char** argv);
int RecordCommand(int argc, char** argv);
int ExampleCommand(int argc, char** argv);
int LiveCommand(int argc, char** argv);
int BakeCommand(int argc, char** argv);
int EditCommand(int argc, char** argv);
int ShowCommand(int argc, char** argv);
int DraftsCommand(int argc, char** argv);
int FilesCommand(int argc, char** argv);

}  // namespace keypose::armature
