// The moving mesh of a performance's shot, played.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api } from '../api'
import type { Pose } from '../api'
import { ShotPage } from '../shot_choice'
import { useStudio } from '../state'
import { parseMesh } from '../view/mesh_data'
import { ViewerStage } from '../view/stage'
import type { Viewer } from '../view/viewer'
import { percent } from '../words'
import { ColoursBar } from './motion/colours_bar'
import { useColours } from './motion/use_colours'
import { useFrame, usePlaying } from './timeline/desk'
import { Player } from './timeline/player'
import { useShortcuts } from './timeline/shortcuts'
import { Sound } from './timeline/sound'
import { PlayButtons } from './timeline/transport'
import { useFrames } from './timeline/use_frames'
import type { Made } from './timeline/use_frames'
import { usePauseWhileHidden } from './timeline/use_player'
import './timeline/timeline.css'
import './motion/motion.css'

/** Shows the shot's first frame; true once positions can be put on it. */
function useFirstFrame(viewer: { current: Viewer | null }, shot: string, made: Made): boolean {
  const { complain } = useStudio()
  const [shown, setShown] = useState(false)
  useEffect(() => {
    let current = true
    const load = async () => {
      const data = parseMesh(await api.firstFrame(shot))
      if (!current || !viewer.current) return
      if (data.vertices !== made.frames.vertices)
        throw new Error('The frames have changed while they were read; look again in a moment.')
      viewer.current.show(data, 'plain', true)
      setShown(true)
    }
    setShown(false)
    load().catch((error) => current && complain(error))
    return () => {
      current = false
    }
  }, [viewer, shot, made, complain])
  return shown
}

/** The player of these frames; it stops with the page. */
function usePlayerOf(made: Made): Player {
  const player = useMemo(() => new Player(new Sound()), [])
  player.fps = made.frames.fps
  player.length = player.range = made.frames.count
  usePauseWhileHidden(player)
  return player
}

function Readings({ player, made }: { player: Player; made: Made }) {
  const line = useRef<HTMLSpanElement>(null)
  const slider = useRef<HTMLInputElement>(null)
  const { count, fps, area, volume } = made.frames
  useFrame(player, (frame) => {
    if (slider.current) slider.current.value = String(frame)
    if (!line.current) return
    const sizes = `volume ${percent(volume[frame], 1)}, area ${percent(area[frame], 1)}`
    line.current.textContent =
      `${frame} / ${count - 1} · ${(frame / fps).toFixed(2)} s · ${sizes}`
  })
  return (
    <>
      <input
        ref={slider}
        type="range"
        aria-label="Frame"
        min={0}
        max={count - 1}
        onInput={(event) => player.seek(Number(event.currentTarget.value))}
      />
      <span
        ref={line}
        class="number small motion-reading"
        title="Volume and area over those of the figure at rest"
      />
    </>
  )
}

function Playing({ shot, made }: { shot: string; made: Made }) {
  const viewer = useRef<Viewer | null>(null)
  const player = usePlayerOf(made)
  const shown = useFirstFrame(viewer, shot, made)
  const playing = usePlaying(player)
  const [repeat, setRepeat] = useState(true)
  player.repeat = repeat
  useFrame(player, (frame) => {
    if (shown) viewer.current?.setPositions(made.positions[frame])
  })
  const { next, ...colours } = useColours({ viewer, shown, shot, made, player })
  useEffect(() => {
    if (!playing) viewer.current?.comeToRest()
  }, [player, playing])
  useShortcuts({
    ' ': () => player.toggle(),
    ',': () => player.seek(player.frame - 1),
    '.': () => player.seek(player.frame + 1),
    Home: () => player.seek(0),
    End: () => player.seek(player.length - 1),
    r: () => setRepeat(!repeat),
    c: next,
  })
  return (
    <>
      <ViewerStage label={`The motion of ${shot}`} ready={(one) => (viewer.current = one)} />
      <ColoursBar shot={shot} {...colours} />
      <div class="tl-transport" role="toolbar" aria-label="Transport">
        <PlayButtons player={player} repeat={repeat} setRepeat={setRepeat} />
        <Readings player={player} made={made} />
      </div>
    </>
  )
}

function NoFrames({ shot }: { shot: Pose }) {
  const { steps, running, reload, complain } = useStudio()
  const last = ['follow', 'transfer', 'track']
    .map((rule) => steps.steps.find((one) => one.step === rule && one.pose === shot.name))
    .find((one) => one !== undefined)
  const blocked = running !== null || steps.locked_by !== ''
  return (
    <div class="empty">
      <h2>No motion of {shot.name} yet</h2>
      <p>It is found in the films, and then plays here.</p>
      {last && (
        <button
          class="main"
          disabled={blocked}
          onClick={() => api.run({ until: [last.id] }).then(reload).catch(complain)}
        >
          Run until the motion
        </button>
      )}
    </div>
  )
}

function Shot({ shot }: { shot: Pose }) {
  const { made, ready } = useFrames(shot.name)
  if (!ready) return <div class="empty" />
  if (!made) return <NoFrames shot={shot} />
  return <Playing shot={shot.name} made={made} />
}

export function MotionPage() {
  return (
    <ShotPage
      title="Motion"
      kind="motion"
      show={(shot) => <Shot key={shot.name} shot={shot} />}
    />
  )
}
