// The subcommands of `keypose armature`; each in a file of its own.
#pragma once

namespace keypose::armature {

/// Each gets the command line without the words before the subcommand's own (argv[0] is the
/// program), and returns the exit code. Errors are thrown (core/errors.h).
int CheckCommand(int argc, char** argv);

}  // namespace keypose::armature
