// Turns the views to landmarks and to advised places.
import type { Advice, Pick } from '../../api'
import type { MeshData } from '../../view/mesh_data'
import type { Viewer } from '../../view/viewer'
import { facing } from './linked_turn'
import { pickOn } from './markers'
import type { Item, Side } from './markers'
import { normalOf } from './surface'
import type { Surface } from './surface'

export const kSides: readonly Side[] = ['template', 'pose']
/** How near the views come, in sizes of the figure. */
const kNear = 0.75

export type Surfaces = Record<Side, Surface>

/** Both views see the item; with `near` from near by, else only if it was hidden. */
export function lookAt(surfaces: Surfaces, item: Item, near: boolean): void {
  for (const side of kSides) {
    const pick = pickOn(item, side)
    if (pick) turnTo(surfaces[side], pick, near)
  }
  if (!pickOn(item, 'pose')) follow(surfaces.pose.viewer, surfaces.template.viewer)
  if (!pickOn(item, 'template')) follow(surfaces.template.viewer, surfaces.pose.viewer)
}

function turnTo(surface: Surface, pick: Pick, near: boolean): void {
  const { viewer, data } = surface
  if (!viewer || !data || pick.face >= data.faces) return
  const place = viewer.placeOf(pick.face, pick.barycentric)
  const direction = facing(normalOf(data, pick.face))
  if (near) viewer.focusOn(place, direction, kNear)
  else if (viewer.isHidden(place)) viewer.setTurn({ ...viewer.turn(), direction })
}

/** An open pair: its place is looked for where the other view looks. */
function follow(viewer: Viewer | null, other: Viewer | null): void {
  if (viewer && other) viewer.setTurn({ ...viewer.turn(), direction: other.turn().direction })
}

export function lookAtAdvice({ viewer, data }: Surface, advice: Advice | undefined): void {
  const place = data && advice ? adviceOnFace(data, advice) : null
  if (!viewer || !data || !advice || !place) return
  viewer.focusOn(advice.place, facing(normalOf(data, place.face)), kNear)
}

/** An advised vertex as a corner of one of its faces; null if it has none. */
export function adviceOnFace(data: MeshData, advice: Advice): Omit<Pick, 'name'> | null {
  const at = data.indices.indexOf(advice.vertex)
  if (at < 0) return null
  const barycentric: [number, number, number] = [0, 0, 0]
  barycentric[at % 3] = 1
  return { face: Math.floor(at / 3), barycentric }
}
