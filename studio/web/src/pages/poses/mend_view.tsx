// A pose's mesh under the brush that mends: smooth, pull, fill a bitten place.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks'

import type { Pose } from '../../api'
import { useKeys } from '../../keys'
import { useStudio } from '../../state'
import { useBrushRing } from '../../view/brush_ring'
import { kScaleGradient } from '../../view/colors'
import { boxOf } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import { ViewerStage } from '../../view/stage'
import type { Hit, Viewer } from '../../view/viewer'
import { hitInMiddle } from '../landmarks/surface'
import {
  kFirstBrush,
  kLargestMend,
  kMendTools,
  kSmallestMend,
  MendPath,
  movedLevels,
} from './mend_model'
import type { MendBrush } from './mend_model'
import { MendSide } from './mend_side'
import type { MendLook } from './mend_side'
import { useMending } from './use_mending'
import type { MendDesk } from './use_mending'

const kClay = '#c9bfae'
/** Of what the brush has touched, on the colour scale. */
const kTouched = 0.75

function sizeOf(mesh: MeshData): number {
  const box = boxOf(mesh.positions)
  return Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2])
}

/** Shows the mesh before or after, or how far each place was moved. */
function useShownMesh(viewer: Viewer | null, desk: MendDesk, look: MendLook) {
  const { before, draft } = desk
  const shown = useRef<Viewer | null>(null)
  useEffect(() => {
    if (!viewer || !before) return
    const fits = draft && draft.positions.length === before.positions.length
    const positions = fits && look !== 'before' ? draft.positions : before.positions
    // Shown anew, and not only moved: the next stroke must meet the surface as it is now.
    viewer.show({ ...before, positions }, 'plain', shown.current === viewer)
    shown.current = viewer
    if (fits && look === 'moved')
      viewer.showValues(movedLevels(before.positions, draft.positions), kClay)
  }, [viewer, before, draft, look])
}

export function MendView({ pose }: { pose: Pose }) {
  const { complain } = useStudio()
  const desk = useMending(pose.name)
  const { mending, strokes, before, paint } = desk
  const [viewer, setViewer] = useState<Viewer | null>(null)
  const [brush, setBrush] = useState<MendBrush>(kFirstBrush)
  const [look, setLook] = useState<MendLook>('after')
  const path = useRef<{ path: MendPath; touched: Float32Array } | null>(null)
  const ring = useBrushRing(viewer, brush.radius)
  useShownMesh(viewer, desk, look)
  useEffect(() => viewer?.rake(), [viewer])

  const lost = strokes.clicks.some((stroke) => stroke.fault !== '')
  const dab = (hit: Hit, phase: 'begin' | 'move' | 'end') => {
    if (!viewer || !before) return
    const size = sizeOf(before)
    if (phase === 'begin') {
      if (lost) return complain('Take out the strokes that are lost first.')
      if (look !== 'after') setLook('after')
      path.current = {
        path: new MendPath(),
        touched: new Float32Array(before.vertices).fill(NaN),
      }
    }
    const now = path.current
    if (!now) return
    if (now.path.add(hit, brush.radius * size)) {
      for (const { vertex } of viewer.verticesNear(hit.place, brush.radius))
        now.touched[vertex] = kTouched
      viewer.showValues(now.touched, kClay)
    }
    if (phase !== 'end') return
    path.current = null
    paint(now.path.stroke(brush, size))
  }
  useLayoutEffect(() => {
    if (!viewer) return
    viewer.onBrush = dab
    return () => {
      viewer.onBrush = null
    }
  })

  const travel = (what: string) => what && setLook('after')
  const resize = (by: number) =>
    setBrush((old) => ({
      ...old,
      radius: Math.min(kLargestMend, Math.max(kSmallestMend, old.radius * by)),
    }))
  useKeys({
    ...Object.fromEntries(
      kMendTools.map(([tool, , key]) => [key, () => setBrush((old) => ({ ...old, tool }))]),
    ),
    '[': () => resize(1 / 1.25),
    ']': () => resize(1.25),
    b: () => setLook((old) => (old === 'before' ? 'after' : 'before')),
    ' ': (event) => {
      if (!viewer?.element.contains(event.target as Node)) return
      const hit = hitInMiddle(viewer, viewer.element)
      if (!hit) return
      dab(hit, 'begin')
      dab(hit, 'end')
    },
    'ctrl+z': () => travel(strokes.undo()),
    'ctrl+shift+z': () => travel(strokes.redo()),
    'ctrl+y': () => travel(strokes.redo()),
  })

  if (!mending) return <div class="empty">Reads what was mended …</div>
  if (!mending.mesh)
    return (
      <div class="empty">
        <h2>Nothing to mend</h2>
        <p>{mending.problem}.</p>
      </div>
    )
  return (
    <div class="figure-bench">
      <div class="figure-main">
        <ViewerStage label={`${pose.name}: 3D view to mend on`} ready={setViewer}>
          <div class="brush-ring" ref={ring} aria-hidden="true" />
          <div class="over">
            <p class="caption-chip" role="status">
              {!before
                ? 'Loads the mesh …'
                : look === 'before'
                  ? 'Before'
                  : 'Drag on the figure to mend it; drag beside it, or with Alt, to turn.'}
            </p>
            {look === 'moved' && (
              <div class="mend-scale small" aria-hidden="true">
                <span>not moved</span>
                <i style={{ background: kScaleGradient }} />
                <span>farthest</span>
              </div>
            )}
          </div>
        </ViewerStage>
      </div>
      <MendSide {...{ desk, brush, look, viewer }} pose={pose.name} change={setBrush} show={setLook} />
    </div>
  )
}
