// The playing character, its onion skin, and what to do while there are no frames.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import { api } from '../../api'
import { useStudio } from '../../state'
import { parseMesh } from '../../view/mesh_data'
import { ViewerStage } from '../../view/stage'
import type { Viewer } from '../../view/viewer'
import { useFrame, usePlaying } from './desk'
import { OnionControls, skins } from './onion'
import type { Onion } from './onion'
import type { Player } from './player'
import { madeFrame, texturesAt } from './timeline_model'
import type { Made } from './use_frames'

/** The textures of the other keys' poses: on the way the figure wears two of them. */
async function loadOthers(
  viewer: { current: Viewer | null },
  made: Made,
  template: string,
  baked: string[],
): Promise<void> {
  const others = made.frames.poses.filter((pose) => pose !== template && baked.includes(pose))
  await viewer.current?.loadBlends(new Map(others.map((pose) => [pose, api.textureUrl(pose)])))
}

/** Shows the template's mesh; true once frames with so many vertices can be put on it. */
function useTemplate(viewer: { current: Viewer | null }, made: Made | null): boolean {
  const { project, complain } = useStudio()
  const [shown, setShown] = useState(false)
  const [, drawAgain] = useState(0)
  const template = project.poses.find((pose) => pose.name === project.template)
  const name = template?.meshes.includes('mesh') ? template.name : ''
  const textured = template?.has_texture ?? false
  const names = project.poses.filter((pose) => pose.has_texture).map((pose) => pose.name)
  const baked = useMemo(() => names, [names.join('/')])
  useEffect(() => {
    let current = true
    const load = async () => {
      const data = parseMesh(await api.mesh(name, 'mesh'))
      if (!current || !viewer.current) return
      if (made && data.vertices !== made.frames.vertices)
        throw new Error('The frames were made from another net: make them again.')
      viewer.current.show(data, textured && data.uvs ? 'texture' : 'plain', true)
      setShown(true)
      if (textured) await viewer.current.loadTexture(api.textureUrl(name))
      if (textured && made) await loadOthers(viewer, made, name, baked)
      drawAgain((old) => old + 1)
    }
    setShown(false)
    const failed = (error: unknown) => {
      if (current) complain(error)
    }
    if (name) load().catch(failed)
    return () => {
      current = false
    }
  }, [name, textured, baked, made, viewer, complain])
  return shown
}

interface Showing {
  viewer: { current: Viewer | null }
  made: Made | null
  player: Player
  fps: number
  onion: Onion
}

/** The clock begins when the first picture is there; all pixels again when it stops. */
function useRunUp(viewer: { current: Viewer | null }, player: Player): void {
  useEffect(() => {
    player.beforeStart = async () => viewer.current?.runUp(1000 / player.fps)
    const unwatch = player.watchState(() => {
      if (!player.playing) viewer.current?.comeToRest()
    })
    return () => {
      player.beforeStart = null
      unwatch()
    }
  }, [viewer, player])
}

/** The frame at the playhead, and once it rests, its neighbours. */
function useShownFrame({ viewer, made, player, fps, onion }: Showing, shown: boolean): void {
  const playing = usePlaying(player)
  const asked = useRef(0)
  const drawSkins = () => {
    asked.current = 0
    if (!viewer.current || !made || !shown) return
    const wanted = onion.on && !player.playing
    const at = madeFrame(made.frames, fps, player.frame)
    const found = wanted ? [...skins(onion, at, made.frames.count)] : []
    viewer.current.setGhosts(
      found.map(([frame, color]) => ({ positions: made.positions[frame], color })),
    )
  }
  useFrame(player, (frame) => {
    if (!made || !shown) return
    const at = madeFrame(made.frames, fps, frame)
    viewer.current?.setPositions(made.positions[at])
    viewer.current?.blendTextures(...texturesAt(made.frames, at))
    // Scrubbing passes many frames between two repaints; the skins of the last are enough.
    if (onion.on && !player.playing && asked.current === 0)
      asked.current = requestAnimationFrame(drawSkins)
  })
  useEffect(drawSkins, [onion, playing, made, fps, shown])
  useEffect(() => () => cancelAnimationFrame(asked.current), [])
}

export function Stage(props: {
  made: Made | null
  player: Player
  fps: number
  onion: Onion
  setOnion: (onion: Onion) => void
  children?: ComponentChildren
}) {
  const viewer = useRef<Viewer | null>(null)
  const shown = useTemplate(viewer, props.made)
  useShownFrame({ ...props, viewer }, shown)
  useRunUp(viewer, props.player)
  return (
    <ViewerStage label="The animation" ready={(one) => (viewer.current = one)}>
      {props.children}
      {props.made && (
        <div class="over">
          <OnionControls onion={props.onion} player={props.player} change={props.setOnion} />
        </div>
      )}
    </ViewerStage>
  )
}
