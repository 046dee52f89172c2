// A shooting session: one pose after the other, photograph after photograph, through faults.
#pragma once

#include "capture/shoot/session/shooting_parts.h"

namespace keypose::capture::shoot {

/// Shoots until the person ends it or all is there.
/// @return whether the last pose is complete
/// @throws Cancelled     Ctrl-C
/// @throws UsageError, InputError, DiskError, LockedError
/// @throws ToolError     a device cannot be opened at the start, and nobody is there to wait for
bool RunShootingSession(const ShootingOptions& options, const ShootingParts& parts);

}  // namespace keypose::capture::shoot
