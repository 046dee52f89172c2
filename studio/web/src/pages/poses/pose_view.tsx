// The results of a pose in 3D, with the cameras round them.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { CameraView, Pose } from '../../api'
import { useStudio } from '../../state'
import { azimuthOf, frontOf, frontStep } from '../../view/front'
import { parseMesh } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import { ViewerStage } from '../../view/stage'
import { areaByLevel } from '../../view/scale_picture'
import type { Look, Viewer } from '../../view/viewer'
import { CameraList } from './camera_list'
import { ConfidenceLegend, kConfidenceBins } from './confidence_legend'
import { useLoaded } from './load'

/** In the order in which they are made, with the words for the person. */
const kKinds: [string, string, string][] = [
  ['cloud', 'Cloud', 'Points that several photographs agree on'],
  ['surface', 'Surface', 'The first surface through the cloud'],
  ['refined', 'Refined', 'The surface pulled to the outlines in the photographs'],
  ['clean', 'Clean', 'Closed, without base, in few faces'],
  ['mesh', 'Mesh', 'What is animated: the net that all poses share, in this pose'],
]

/** Which looks a mesh can have. */
function looksOf(pose: Pose, kind: string, data: MeshData | null): Look[] {
  const looks: Look[] = data?.faces === 0 ? [] : ['plain']
  if (kind === 'mesh' && pose.has_texture) looks.push('texture')
  if (kind === 'mesh' && pose.has_confidence && data?.uvs) looks.push('confidence')
  if (data?.colors) looks.push('colors')
  return looks
}

const kLookWords: Partial<Record<Look, string>> = {
  plain: 'Plain',
  texture: 'Textured',
  confidence: 'Confidence',
  colors: 'Colours',
}

export function PoseView({ pose, results }: { pose: Pose; results: string }) {
  const there = kKinds.filter(([kind]) => pose.meshes.includes(kind))
  const [wanted, setWanted] = useState('mesh')
  const kind = there.some(([one]) => one === wanted) ? wanted : (there[there.length - 1]?.[0] ?? '')
  const [look, setLook] = useState<Look>(pose.has_texture ? 'texture' : 'plain')
  const [framed, setFramed] = useState(true)
  const [through, setThrough] = useState('')
  const [viewer, setViewer] = useState<Viewer | null>(null)
  const mesh = useMesh(pose.name, kind, results)
  const cameras = useCameras(pose, results)
  const data = mesh.value?.kind === kind ? mesh.value.data : null
  const looks = looksOf(pose, kind, data)
  const used = looks.includes(look) ? look : (looks[looks.length - 1] ?? 'plain')
  const seen = useShown(viewer, pose.name, data, used)
  useEffect(() => {
    if (viewer && data) viewer.showCameras(framed ? cameras : [], through)
  }, [viewer, data, cameras, framed, through])
  const lookFrom = (name: string) => {
    setThrough(name)
    const camera = cameras.find((one) => one.name === name)
    if (camera) viewer?.lookThrough(camera)
    else viewer?.lookFreely()
  }
  if (there.length === 0)
    return (
      <div class="empty">
        <h2>No surface yet</h2>
        <p>Press Run: the cloud shows here as soon as the photographs are matched.</p>
      </div>
    )
  return (
    <>
      <div class="tools row">
        <div class="choice" role="group" aria-label="What to show">
          {there.map(([one, words, why]) => (
            <button
              key={one}
              title={why}
              aria-pressed={one === kind}
              onClick={() => setWanted(one)}
            >
              {words}
            </button>
          ))}
        </div>
        {looks.length > 1 && (
          <div class="choice" role="group" aria-label="Look">
            {looks.map((one) => (
              <button key={one} aria-pressed={one === used} onClick={() => setLook(one)}>
                {kLookWords[one]}
              </button>
            ))}
          </div>
        )}
        <div class="row end">
          <FrontButton viewer={viewer} />
          <button
            aria-pressed={framed && cameras.length > 0}
            disabled={cameras.length === 0}
            onClick={() => setFramed(!framed)}
          >
            Show cameras
          </button>
        </div>
      </div>
      <div class={cameras.length > 0 ? 'beside' : 'alone'}>
        <ViewerStage label={`${pose.name} in 3D`} ready={setViewer}>
          <div class="over">
            <p class="caption-chip number" role="status">
              {mesh.error || (data ? sizeOf(data) : 'Loads …')}
            </p>
            {used === 'confidence' && seen && <ConfidenceLegend bins={seen} />}
          </div>
        </ViewerStage>
        {cameras.length > 0 && <CameraList cameras={cameras} current={through} choose={lookFrom} />}
      </div>
    </>
  )
}

/** Says once which side is the figure's front, for the film, other programs and all views. */
function FrontButton({ viewer }: { viewer: Viewer | null }) {
  const { project, steps, tell, complain, reload } = useStudio()
  const step = frontStep(steps)
  if (!step) return null
  const say = async () => {
    if (!viewer) return
    const value = String(azimuthOf(viewer.turn().direction))
    try {
      const { revision } = project
      await api.setOption({ step, pose: '', option: 'front', value, revision })
      tell('This side is the front: of the film, in other programs, and where views begin.')
      await reload()
    } catch (error) {
      complain(error)
    }
  }
  const now = frontOf(steps)
  const words = now === 0 ? 'the side of the first photograph' : `${now}° from the first photograph`
  return (
    <button
      title={`Turn the figure to face you, then press. So far: ${words}`}
      onClick={() => void say()}
    >
      This is the front
    </button>
  )
}

function sizeOf(data: MeshData): string {
  const vertices = data.vertices.toLocaleString('en')
  if (data.faces === 0) return `${vertices} points`
  return `${data.faces.toLocaleString('en')} faces · ${vertices} vertices`
}

/** Loads one of the pose's meshes; those seen before are kept until the pose is made anew. */
export function useMesh(pose: string, kind: string, results: string) {
  const kept = useRef(new Map<string, MeshData>())
  const keptFor = useRef('')
  return useLoaded(async () => {
    const now = `${pose} ${results}`
    if (keptFor.current !== now) kept.current.clear()
    keptFor.current = now
    if (!kind) return { kind, data: null }
    const data = kept.current.get(kind) ?? parseMesh(await api.mesh(pose, kind))
    kept.current.set(kind, data)
    return { kind, data }
  }, [pose, kind, results])
}

export function useCameras(pose: Pose, results: string): CameraView[] {
  const none = useRef<CameraView[]>([])
  const load = () => (pose.has_cameras ? api.cameras(pose.name) : Promise.resolve([]))
  return useLoaded(load, [pose.name, pose.has_cameras, results]).value ?? none.current
}

/**
 * Shows the mesh; the view stays turned as it is while the pose stays the same. Returns the share
 * of the surface by confidence, when that is shown.
 */
function useShown(viewer: Viewer | null, pose: string, data: MeshData | null, look: Look) {
  const { complain } = useStudio()
  const [seen, setSeen] = useState<{ data: MeshData; bins: number[] } | null>(null)
  const shown = useRef<{ viewer: Viewer; pose: string } | null>(null)
  const textured = useRef<MeshData | null>(null)
  useEffect(() => {
    if (!viewer || !data) return
    let wanted = true
    const show = () => {
      if (!wanted) return
      const same = shown.current?.viewer === viewer && shown.current.pose === pose
      viewer.show(data, look, same)
      shown.current = { viewer, pose }
    }
    if (look === 'texture' && textured.current !== data)
      viewer.loadTexture(api.textureUrl(pose)).then(() => {
        if (wanted) textured.current = data
        show()
      }, complain)
    else if (look === 'confidence' && seen?.data !== data)
      viewer.loadConfidence(api.confidenceUrl(pose)).then((grey) => {
        if (wanted) setSeen({ data, bins: areaByLevel(data, grey, kConfidenceBins) })
        show()
      }, complain)
    else show()
    return () => void (wanted = false)
  }, [viewer, pose, data, look])
  return seen?.data === data ? seen.bins : null
}
