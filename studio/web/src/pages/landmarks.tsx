// Landmarks: pairs of places on the template and a pose, and what is painted on the template.
import { useState } from 'preact/hooks'

import { useStudio } from '../state'
import '../view/frame_view.css'
import './landmarks/landmarks.css'
import { PaintBench } from './landmarks/paint_bench'
import { PhotoBench } from './landmarks/photo_bench'
import { PickBench } from './landmarks/pick_bench'

type Mode = 'pick' | 'paint'

/** The pose in the address '#/landmarks/POSE', so that other pages can link to it. */
function poseOfAddress(): string {
  const name = location.hash.split('/')[2] ?? ''
  try {
    return decodeURIComponent(name)
  } catch {
    return name
  }
}

function ModeChoice(props: { mode: Mode; onMode: (mode: Mode) => void }) {
  const button = (mode: Mode, name: string, title: string) => (
    <button aria-pressed={props.mode === mode} title={title} onClick={() => props.onMode(mode)}>
      {name}
    </button>
  )
  return (
    <div class="choice lm-modes" role="group" aria-label="Mode">
      {button('pick', 'Pick', 'Pairs of places on the pose that gives its net, and another')}
      {button('paint', 'Paint', 'Stiffness and regions, on the pose that gives its net')}
    </div>
  )
}

export function LandmarksPage() {
  const { project } = useStudio()
  const [mode, setMode] = useState<Mode>('pick')
  const [wanted, setWanted] = useState(poseOfAddress)
  const template = project.poses.find((pose) => pose.template)
  const poses = project.poses.filter((pose) => !pose.template)
  const pose = poses.find((one) => one.name === wanted) ?? poses[0]
  const choose = (name: string) => {
    history.replaceState(null, '', `#/landmarks/${encodeURIComponent(name)}`)
    setWanted(name)
  }
  if (!template)
    return (
      <main class="empty">
        <h1>No pose gives the others their net yet</h1>
        <p>
          Landmarks go from that pose, the template, to the others. Name it in the project’s file,
          pipeline.yaml: <code>template: POSE</code>.
        </p>
      </main>
    )
  const modes = <ModeChoice mode={mode} onMode={setMode} />
  if (mode === 'paint') return <PaintBench template={template} modes={modes} />
  if (!pose)
    return (
      <main class="empty">
        <h1>Landmarks need a second pose</h1>
        <p>
          They join the pose that gives the others their net with another one; this project has only{' '}
          {template.name}.
        </p>
        <p>
          <a class="button" href="#/poses">
            Add a pose
          </a>{' '}
          <button onClick={() => setMode('paint')}>Paint {template.name} instead</button>
        </p>
      </main>
    )
  // A pose from few photographs has no scan to pick on: it is picked in the photographs.
  const Bench = pose.method === 'fit' ? PhotoBench : PickBench
  return (
    <Bench template={template} pose={pose} poses={poses} onPose={choose} modes={modes} />
  )
}
