// A pose before and after, in 3D: one camera for both.
import { useEffect, useRef, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { kScaleGradient } from '../../view/colors'
import { boxOf, parseMesh } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import { ViewerStage } from '../../view/stage'
import type { Viewer } from '../../view/viewer'
import { percent } from '../../words'
import { useLoaded } from '../poses/load'
import { Pair } from './pair'
import type { Mode } from './pair'
import { reviewApi } from './review_api'
import type { Version } from './review_api'
import { scaleEnd } from './review_model'

interface Shown {
  before: MeshData | null
  after: MeshData
  /** around both, so that both views have one camera */
  box: number[]
}

async function loadBoth(before: string, after: string): Promise<Shown> {
  const load = async (at: string) => (at ? parseMesh(await reviewApi.mesh(at)) : null)
  const [first, second] = await Promise.all([load(before), load(after)])
  const box = boxOf(second!.positions)
  boxOf(first?.positions ?? second!.positions).forEach((value, k) => {
    box[k] = k < 3 ? Math.min(box[k], value) : Math.max(box[k], value)
  })
  return { before: first, after: second!, box }
}

interface Distances {
  before: Float32Array
  after: Float32Array
  end: number
}

async function loadDistances(before: string, after: string): Promise<Distances> {
  const [first, second] = await Promise.all([
    reviewApi.distance(before, after),
    reviewApi.distance(after, before),
  ])
  return { before: first, after: second, end: scaleEnd(first, second) }
}

export function FigurePair(props: {
  pose: string
  before: Version | null
  after: Version
  mode: Mode
  gain: number
}) {
  const { pose, before, after, mode, gain } = props
  const { complain } = useStudio()
  const meshes = [before?.mesh ?? '', after.mesh] as const
  const shown = useLoaded(() => loadBoth(...meshes), [...meshes]).value
  const coloured = mode === 'distance' && before !== null
  const distances = useLoaded(
    async () => (coloured ? loadDistances(...meshes) : null),
    [...meshes, coloured],
  ).value
  const [views, setViews] = useState<{ before: Viewer | null; after: Viewer | null }>({
    before: null,
    after: null,
  })
  const latest = useRef(views)
  latest.current = views
  useEffect(() => {
    const link = (from: Viewer | null, to: () => Viewer | null) => {
      if (from) from.onTurn = (turn) => to()?.setTurn(turn)
    }
    link(views.before, () => latest.current.after)
    link(views.after, () => latest.current.before)
  }, [views])
  useEffect(() => {
    let wanted = true
    const show = async (viewer: Viewer | null, data: MeshData | null, version: Version | null) => {
      if (!viewer || !data || !version || !shown) return
      if (version.texture) await viewer.loadTexture(reviewApi.fileUrl(version.texture))
      if (!wanted) return  // another pair is shown by now
      viewer.show(data, version.texture && !coloured ? 'texture' : 'plain', false, shown.box)
    }
    const all = async () => {
      await show(views.before, shown?.before ?? null, before)
      await show(views.after, shown?.after ?? null, after)
      if (!wanted || !distances || !coloured) return
      views.before?.showValues(distances.before.map((value) => value / distances.end))
      views.after?.showValues(distances.after.map((value) => value / distances.end))
    }
    all().catch((error) => wanted && complain(error))
    return () => void (wanted = false)
  }, [views, shown, distances, coloured, before?.texture, after.texture])
  const stage = (which: 'before' | 'after', words: string) => (
    <ViewerStage
      label={`${pose}, ${words}`}
      ready={(viewer) => setViews((old) => ({ ...old, [which]: viewer }))}
    />
  )
  if (!before) return <div class="rv-pair">{stage('after', 'as it is')}</div>
  return (
    <Pair
      mode={mode}
      gain={gain}
      before={stage('before', 'before')}
      after={stage('after', 'after')}
      over={coloured && distances && <DistanceLegend end={distances.end} />}
    />
  )
}

function DistanceLegend({ end }: { end: number }) {
  return (
    <figure class="legend card">
      <figcaption>Distance to the other surface, of the diagonal</figcaption>
      <div class="scale" style={{ background: kScaleGradient }} />
      <div class="ends small soft number">
        <span>0</span>
        <span>{percent(end, 2)} and more</span>
      </div>
    </figure>
  )
}
