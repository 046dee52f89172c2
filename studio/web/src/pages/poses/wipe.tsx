// A photograph and the textured mesh seen from its camera, with an edge between them to drag.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { CameraView, Pose } from '../../api'
import { Picture } from '../../picture'
import { useStudio } from '../../state'
import { ViewerStage } from '../../view/stage'
import type { Viewer } from '../../view/viewer'
import { useSize } from './load'
import { useCameras, useMesh } from './pose_view'
import { Strip } from './strip'

type Behind = 'photograph' | 'plain'

export function Wipe(props: {
  pose: Pose
  results: string
  item: string
  choose: (name: string) => void
}) {
  const { pose, results } = props
  const cameras = useCameras(pose, results)
  const camera = cameras.find((one) => one.name === props.item) ?? cameras[0]
  const [behind, setBehind] = useState<Behind>('plain')
  if (!pose.has_cameras || !pose.meshes.includes('mesh'))
    return (
      <div class="empty">
        <h2>Nothing to compare yet</h2>
        <p>Press Run: the wipe needs the placed cameras and the mesh of {pose.name}.</p>
      </div>
    )
  return (
    <>
      <div class="tools row">
        <p class="small soft">
          {camera?.name} left of the edge, the {pose.has_texture ? 'textured mesh' : 'mesh'} right
          of it. Drag the edge, or use the arrow keys.
        </p>
        <div class="row end">
          <span class="small soft" id="behind">
            Behind the mesh
          </span>
          <div class="choice" role="group" aria-labelledby="behind">
            <button aria-pressed={behind === 'plain'} onClick={() => setBehind('plain')}>
              Plain
            </button>
            <button aria-pressed={behind === 'photograph'} onClick={() => setBehind('photograph')}>
              Photograph
            </button>
          </div>
        </div>
      </div>
      {camera && <Pair pose={pose} results={results} camera={camera} behind={behind} />}
      <Strip
        src={(one) => api.photoUrl(pose.name, one, 320)}
        label="Cameras"
        names={cameras.map((one) => one.name)}
        current={camera?.name ?? ''}
        choose={props.choose}
      />
    </>
  )
}

function Pair(props: { pose: Pose; results: string; camera: CameraView; behind: Behind }) {
  const { pose, camera } = props
  const { element, size } = useSize<HTMLDivElement>()
  const [edge, setEdge] = useState(50)
  const [viewer, setViewer] = useState<Viewer | null>(null)
  useRender(viewer, props)
  // Both lie in a box of the photograph's shape, as large as the room allows.
  const scale = Math.min(size.width / camera.width, size.height / camera.height)
  const pixels = (length: number) => `${Math.floor(scale * length)}px`
  const box = { width: pixels(camera.width), height: pixels(camera.height) }
  return (
    <div ref={element} class="room">
      <div class="pair" style={box}>
        <Picture
          src={api.photoUrl(pose.name, camera.name, 1600, true)}
          alt={`Photograph ${camera.name}`}
          draggable={false}
        />
        {/* The render is a picture here, so keys and screen readers pass it by. */}
        <div
          class={`render ${props.behind}`}
          inert
          style={{ clipPath: `inset(0 0 0 ${edge}%)` }}
        >
          <ViewerStage label="Render" ready={setViewer} />
        </div>
        <Edge edge={edge} move={setEdge} label="Share of the photograph" />
      </div>
    </div>
  )
}

/** Shows the mesh once, then looks through the chosen camera whenever it changes. */
function useRender(
  viewer: Viewer | null,
  { pose, results, camera }: { pose: Pose; results: string; camera: CameraView },
): void {
  const { complain } = useStudio()
  const data = useMesh(pose.name, 'mesh', results).value?.data ?? null
  const latest = useRef(camera)
  latest.current = camera
  useEffect(() => {
    if (!viewer || !data) return
    let wanted = true
    const texture = pose.has_texture ? viewer.loadTexture(api.textureUrl(pose.name)) : null
    Promise.resolve(texture).then(() => {
      if (!wanted) return
      viewer.show(data, pose.has_texture ? 'texture' : 'plain')
      viewer.lookThrough(latest.current)
    }, complain)
    return () => void (wanted = false)
  }, [viewer, data, pose.has_texture])
  useEffect(() => {
    if (viewer && data) viewer.lookThrough(camera)
  }, [viewer, data, camera])
}

/** The handle between two things in one place; `edge` is where it stands, in percent. */
export function Edge(props: { edge: number; move: (edge: number) => void; label: string }) {
  const { edge, move } = props
  const drag = (event: PointerEvent) => {
    const handle = event.currentTarget as HTMLElement
    if (!handle.hasPointerCapture(event.pointerId)) return
    const box = handle.parentElement!.getBoundingClientRect()
    move(Math.min(100, Math.max(0, (100 * (event.clientX - box.left)) / box.width)))
  }
  const key = (event: KeyboardEvent) => {
    const step = event.shiftKey ? 10 : 2
    const places: Record<string, number> = {
      ArrowLeft: edge - step,
      ArrowDown: edge - step,
      ArrowRight: edge + step,
      ArrowUp: edge + step,
      Home: 0,
      End: 100,
    }
    if (!(event.key in places)) return
    event.preventDefault()
    move(Math.min(100, Math.max(0, places[event.key])))
  }
  return (
    <div
      class="edge"
      role="slider"
      tabIndex={0}
      aria-label={props.label}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(edge)}
      aria-valuetext={`${Math.round(edge)} %`}
      style={{ left: `${edge}%` }}
      onPointerDown={(event) => {
        event.preventDefault()
        event.currentTarget.focus()
        event.currentTarget.setPointerCapture(event.pointerId)
      }}
      onPointerMove={drag}
      onKeyDown={key}
    >
      <i aria-hidden="true">‹ ›</i>
    </div>
  )
}
