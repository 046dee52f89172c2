// What a posed theropod is made of.
#pragma once

#include "armature/example/theropod.h"
#include "armature/example/theropod_body.h"
#include "armature/live/posed_puppet.h"
#include "armature/skinning/stick_mesh.h"

namespace keypose::armature {

/// The generated theropod as ball and stick.
inline PuppetParts TheropodParts() {
  PuppetParts parts;
  parts.armature = MakeTheropod();
  parts.plan = MakeTheropodChains(parts.armature);
  parts.skeleton = SkeletonOfClip(MakeTheropodSkeleton(), false);
  parts.world_from_armature = PlacementOf(parts.armature, parts.plan, parts.skeleton, false);
  StickFigure figure = MakeStickFigure(SkinBonesOf(parts.skeleton));
  parts.mesh = figure.mesh;
  parts.weights = figure.weights;
  return parts;
}

}  // namespace keypose::armature
