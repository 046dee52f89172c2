// One view with its mesh: loads it, shows it, and says in words why there is none.
import type { ComponentChildren } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Pose, Steps } from '../../api'
import { parseMesh } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import { shownFront, turnedToFront } from '../../view/front'
import { ViewerStage } from '../../view/stage'
import type { Turn, Viewer } from '../../view/viewer'

/** The whole figure from a little above, as large as a tall view allows. */
export const wholeView = (): Turn =>
  turnedToFront({ direction: [0.35, -0.9, 0.28], distance: 1.62 }, shownFront.degrees)

/** Meshes by address and version: to change the page's mode must not load them again. */
const kept = new Map<string, Promise<MeshData>>()
const kKept = 4

function loadMesh(key: string, load: () => Promise<ArrayBuffer>): Promise<MeshData> {
  const known = kept.get(key)
  if (known) return known
  const loading = load().then(parseMesh)
  loading.catch(() => kept.delete(key))
  kept.set(key, loading)
  for (const old of [...kept.keys()].slice(0, -kKept)) kept.delete(old)
  return loading
}

/** Changes when a step of the pose has made its results anew. */
export function versionOf(steps: Steps, pose: string): string {
  const own = steps.steps.filter((step) => step.pose === pose && step.stage !== 'register')
  return own.map((step) => step.seconds).join(' ')
}

export interface Surface {
  /** of the pose, or of what else is shown */
  name: string
  viewer: Viewer | null
  /** null: not there, or not yet */
  data: MeshData | null
  /** why there is no mesh, or '' */
  missing: string
  ready: (viewer: Viewer | null) => void
}

/** A mesh of the server's, and how it is shown. */
export interface ShownMesh {
  name: string
  /** another mesh has another one */
  key: string
  there: boolean
  load: () => Promise<ArrayBuffer>
  /** the address of its texture, or '' */
  texture: string
  /** why it is not there */
  missing: string
}

/** The mesh on which picks of a pose are made, and the view that shows it. */
export function useSurface(pose: Pose, steps: Steps, plain: boolean): Surface {
  const what = pose.template ? 'mesh' : 'clean'
  return useMeshSurface(
    {
      name: pose.name,
      key: JSON.stringify([pose.name, what, versionOf(steps, pose.name)]),
      there: pose.meshes.includes(what),
      load: () => api.mesh(pose.name, what),
      texture: pose.has_texture ? api.textureUrl(pose.name) : '',
      missing: pose.template
        ? `${pose.name} has no mesh yet: press Run, then mark it here.`
        : `${pose.name} has no cleaned mesh yet: press Run, then mark it here.`,
    },
    plain,
  )
}

export function useMeshSurface(mesh: ShownMesh, plain: boolean): Surface {
  const [viewer, setViewer] = useState<Viewer | null>(null)
  const [data, setData] = useState<MeshData | null>(null)
  const [problem, setProblem] = useState('')
  useEffect(() => {
    let wanted = true
    setData(null)
    setProblem('')
    if (mesh.there)
      loadMesh(mesh.key, mesh.load).then(
        (loaded) => wanted && setData(loaded),
        (error: Error) => wanted && setProblem(error.message),
      )
    return () => {
      wanted = false
    }
  }, [mesh.key, mesh.there])

  const fresh = useRef<Viewer | null>(null)
  const textured = mesh.texture !== '' && data?.uvs != null
  useEffect(() => {
    if (!viewer || !data) return
    viewer.show(data, 'plain')
    // Another pose is then seen from where the last one was.
    if (fresh.current !== viewer) viewer.setTurn(wholeView())
    fresh.current = viewer
    if (textured) viewer.loadTexture(mesh.texture).catch(() => undefined)
  }, [viewer, data, textured, mesh.texture])
  useEffect(() => {
    if (!viewer || !data) return
    const coloured = textured ? 'texture' : data.colors ? 'colors' : 'plain'
    viewer.setLook(plain ? 'plain' : coloured)
  }, [viewer, data, textured, plain])

  return {
    name: mesh.name,
    viewer,
    data,
    missing: mesh.there ? problem : mesh.missing,
    ready: setViewer,
  }
}

export function SurfaceStage(props: {
  surface: Surface
  label: string
  children?: ComponentChildren
}) {
  const { surface } = props
  return (
    <ViewerStage label={props.label} ready={surface.ready}>
      {!surface.data && (
        <div class="lm-wait" role="status">
          {surface.missing || 'Loading the mesh…'}
        </div>
      )}
      <div class="lm-cross" aria-hidden="true" />
      {props.children}
    </ViewerStage>
  )
}

/** The normal of a face, not scaled to one length. */
export function normalOf(data: MeshData, face: number): [number, number, number] {
  const at = (corner: number, k: number) => data.positions[3 * data.indices[3 * face + corner] + k]
  const u = [0, 1, 2].map((k) => at(1, k) - at(0, k))
  const v = [0, 1, 2].map((k) => at(2, k) - at(0, k))
  return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/** Picks at the middle of a view that has the focus: the way to pick without a mouse. */
export function hitInMiddle(viewer: Viewer, canvas: Element) {
  const box = canvas.getBoundingClientRect()
  return viewer.hitAt(box.left + box.width / 2, box.top + box.height / 2)
}
