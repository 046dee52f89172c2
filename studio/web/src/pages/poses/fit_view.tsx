// How well the template lies on the scan of another pose, as colours on the registered mesh.
import { useEffect, useMemo, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Pose } from '../../api'
import { percent } from '../../words'
import { kScaleGradient } from '../../view/colors'
import { ViewerStage } from '../../view/stage'
import type { Viewer } from '../../view/viewer'
import { figuresOf } from '../landmarks/fit_figures'
import type { FitFigures } from '../landmarks/fit_figures'
import { useLoaded } from './load'
import { useMesh } from './pose_view'

/** The scale's end, as a share of the diagonal. */
const kWorst = 0.01
const kBins = 40

interface Fit extends FitFigures {
  /** the share of vertices that lie farther than the scale's end */
  beyond: number
  /** the share of vertices in each part of the scale */
  bins: number[]
}

function summaryOf(values: Float32Array): Fit | null {
  const figures = figuresOf(values)
  if (!figures) return null
  const known = values.filter(Number.isFinite)
  const bins = new Array<number>(kBins).fill(0)
  let beyond = 0
  for (const value of known) {
    if (value > kWorst) ++beyond
    else ++bins[Math.min(kBins - 1, Math.floor((value / kWorst) * kBins))]
  }
  return {
    ...figures,
    beyond: beyond / known.length,
    bins: bins.map((number) => number / known.length),
  }
}

export function FitView({ pose, results }: { pose: Pose; results: string }) {
  const [viewer, setViewer] = useState<Viewer | null>(null)
  const fitted = pose.method === 'fit'
  const registered = !fitted && pose.meshes.includes('mesh')
  const mesh = useMesh(pose.name, registered ? 'mesh' : '', results)
  const loadFit = async () => (registered ? api.fit(pose.name) : null)
  const fit = useLoaded(loadFit, [pose.name, registered, results])
  const data = mesh.value?.data ?? null
  const values = fit.value?.length === data?.vertices ? fit.value : null
  const summary = useMemo(() => (values ? summaryOf(values) : null), [values])
  useEffect(() => {
    if (!viewer || !data || !values) return
    viewer.show(data, 'plain', true)
    viewer.showValues(values.map((value) => value / kWorst))
  }, [viewer, data, values])
  if (fitted)
    return (
      <div class="empty">
        <h2>From few photographs</h2>
        <p>
          The net is bent into the photographs of {pose.name}: there is no scan to measure
          against. Compare the two in the wipe; the report has the overlap in each photograph.
        </p>
      </div>
    )
  if (!pose.meshes.includes('clean') && !registered)
    return (
      <div class="empty">
        <h2>No surface yet</h2>
        <p>Press Run: the net can be laid on {pose.name} when it has a surface.</p>
      </div>
    )
  if (!registered)
    return (
      <div class="empty">
        <h2>Without the net yet</h2>
        <p>Pick the same places on both figures: then the net of triangles is laid on {pose.name}.</p>
        <a class="button" href="#/landmarks">
          Open Landmarks
        </a>
      </div>
    )
  const trouble = fit.error || mesh.error
  return (
    <>
      <p class="tools fit-words" role="status">
        {summary ? <Words fit={summary} /> : trouble || 'Measures the distance to the scan …'}
      </p>
      <div class="alone">
        <ViewerStage label={`${pose.name}: distance to its scan`} ready={setViewer}>
          <div class="over">{summary && <Legend fit={summary} />}</div>
        </ViewerStage>
      </div>
    </>
  )
}

function Words({ fit }: { fit: Fit }) {
  return (
    <>
      Half of the vertices lie within <b class="number">{percent(fit.median, 2)}</b> of the diagonal
      from the scan, 95 % within <b class="number">{percent(fit.most, 2)}</b>.{' '}
      <span class="soft">
        {fit.beyond > 0
          ? `${percent(fit.beyond, 1)} lie farther than the scale shows.`
          : 'None lies farther than the scale shows.'}
      </span>
    </>
  )
}

function Legend({ fit }: { fit: Fit }) {
  const highest = Math.max(...fit.bins) || 1
  const place = (value: number) => `${Math.min(100, (100 * value) / kWorst)}%`
  return (
    <figure class="legend card">
      <figcaption>Distance to the scan, of the diagonal</figcaption>
      <svg viewBox={`0 0 ${kBins} 20`} preserveAspectRatio="none" aria-hidden="true">
        {fit.bins.map((share, i) => (
          <rect
            key={i}
            x={i}
            width={0.9}
            y={20 - (20 * share) / highest}
            height={(20 * share) / highest}
          />
        ))}
      </svg>
      <div class="scale" style={{ background: kScaleGradient }}>
        <i style={{ left: place(fit.median) }} title="median" />
        <i style={{ left: place(fit.most) }} title="95 %" />
      </div>
      <div class="ends small soft number">
        <span>0</span>
        <span>0.5 %</span>
        <span>1 % and more</span>
      </div>
    </figure>
  )
}
