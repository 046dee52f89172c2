// The mesh of the pose that a frame shows, with the clicks' places on it.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Pose } from '../../api'
import { useStudio } from '../../state'
import { parseMesh } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import { ViewerStage } from '../../view/stage'
import type { Hit, Marker, Viewer } from '../../view/viewer'
import { versionOf } from '../landmarks/surface'
import type { Click } from './shot_api'

export interface Place {
  name: string
  click: Pick<Click, 'face' | 'barycentric' | 'vertex'>
  chosen: boolean
}

/** The pose's own mesh; before there is one, the template's, whose faces it will have. */
function meshOf(pose: Pose | undefined, template: Pose | undefined): Pose | null {
  if (pose?.meshes.includes('mesh')) return pose
  return template?.meshes.includes('mesh') ? template : null
}

function useMesh(pose: Pose | undefined, viewer: Viewer | null) {
  const { project, steps, complain } = useStudio()
  const template = project.poses.find((one) => one.template)
  const shown = meshOf(pose, template)
  const textured = pose?.has_texture ? pose : template?.has_texture ? template : null
  const [data, setData] = useState<MeshData | null>(null)
  const version = shown ? versionOf(steps, shown.name) : ''
  useEffect(() => {
    if (!viewer || !shown) return setData(null)
    let current = true
    const load = async () => {
      const mesh = parseMesh(await api.mesh(shown.name, 'mesh'))
      if (!current) return
      // The last pose is seen from where this one then is: the same place is found at once.
      viewer.show(mesh, textured && mesh.uvs ? 'texture' : 'plain', true)
      setData(mesh)
      if (textured && mesh.uvs) await viewer.loadTexture(api.textureUrl(textured.name))
    }
    setData(null)
    load().catch((error) => current && complain(error))
    return () => {
      current = false
    }
  }, [viewer, shown?.name, version, textured?.name, complain])
  return { data, shown }
}

function placeOf(viewer: Viewer, data: MeshData, click: Place['click']): Marker['place'] {
  if (click.face !== undefined && click.barycentric)
    return viewer.placeOf(click.face, click.barycentric)
  const at = 3 * (click.vertex ?? 0)
  return at < data.positions.length
    ? [data.positions[at], data.positions[at + 1], data.positions[at + 2]]
    : [0, 0, 0]
}

export function PoseView(props: {
  pose: Pose | undefined
  places: Place[]
  onPick: (hit: Hit) => void
  onChoose: (name: string) => void
  onMove: (name: string, hit: Hit) => void
}) {
  const [viewer, setViewer] = useState<Viewer | null>(null)
  const { data, shown } = useMesh(props.pose, viewer)
  const stage = useRef<HTMLDivElement>(null)
  const show = () => {
    if (!viewer || !data) return
    viewer.setMarkers(
      props.places.map(({ name, click, chosen }) => ({
        name,
        place: placeOf(viewer, data, click),
        kind: chosen ? 'chosen' : 'landmark',
      })),
    )
  }
  useEffect(show, [viewer, data, JSON.stringify(props.places)])
  // At once, not after the next picture: a click must not meet what was true before the last one.
  useLayoutEffect(() => {
    if (!viewer) return
    viewer.onPick = (hit) => hit && data && props.onPick(hit)
    viewer.onMarker = (name) => {
      props.onChoose(name)
      show() // a hand that trembled has moved the marker
    }
    viewer.onMarkerDrag = (name, hit, done) => {
      viewer.moveMarker(name, hit.place)
      if (done) props.onMove(name, hit)
    }
  })
  const key = (event: KeyboardEvent) => {
    if (event.key !== ' ' || !viewer || !data) return
    event.preventDefault()
    const box = viewer.element.getBoundingClientRect()
    const hit = viewer.hitAt(box.left + box.width / 2, box.top + box.height / 2)
    if (hit) props.onPick(hit)
  }
  const name = props.pose?.name
  return (
    <div ref={stage} class="shot-pose" onKeyDown={key}>
      <ViewerStage label={name ? `${name}: 3D view` : '3D view'} ready={setViewer}>
        {!data && (
          <div class="shot-wait" role="status">
            {!name
              ? 'This frame shows no pose. Choose one below it, or click on a frame that has one.'
              : shown
                ? 'Loading the mesh…'
                : `${name} has no mesh yet: press Run, then click here.`}
          </div>
        )}
        {data && <span class="tag shot-kind">{name ?? ''}</span>}
        <div class="shot-cross" aria-hidden="true" />
      </ViewerStage>
    </div>
  )
}
