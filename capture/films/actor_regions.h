// Which regions of a cut are the actor.
#pragma once

#include "core/values/image.h"

namespace keypose::capture {

struct ActorRegions {
  Image8 mask;       ///< 255 in the actor: the main region, and pieces beside it
  double other = 0;  ///< area of the largest region that was left out, over the actor's
};

/// The region that covers most of `zone`, with smaller ones near it: a foot behind a rail is cut
/// off from its leg. Far ones are another person, or a thing.
/// @param regions  255 in all that looks like the actor
/// @param zone     255 where the actor is expected, e.g. where it was in the frame before; empty:
/// anywhere
ActorRegions ChooseActor(const Image8& regions, const Image8& zone);

/// A mask with a margin, as the zone of the next frame.
Image8 ZoneAround(const Image8& mask);

}  // namespace keypose::capture
