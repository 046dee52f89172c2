// `keypose landmarks bind`: rewrites files that hold vertex or face numbers, so that they stay
// valid when the mesh is rebuilt.
#pragma once

namespace keypose::registration {

/// Runs the command line after the word `bind`.
/// @return the exit code
int BindMain(int argc, char** argv);

}  // namespace keypose::registration
