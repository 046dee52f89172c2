// The cameras of a performance: points of known place, clicked in a still picture of each, and the
// cameras that follow from them.
import { useState } from 'preact/hooks'

import { useKeys } from '../keys'
import { useStudio } from '../state'
import { SendFiles } from '../uploads/send_files'
import { CalibrateCard, CameraErrors } from './cameras/calibrate_card'
import { CameraView } from './cameras/camera_view'
import { PointTable } from './cameras/point_table'
import { pointsApi } from './cameras/points_api'
import type { Calibration } from './cameras/points_api'
import { clicksOf, withoutCamera, withoutClick } from './cameras/points_model'
import { usePoints } from './cameras/use_points'
import type { PointsDesk } from './cameras/use_points'
import { FrameSlider } from './films/frame_slider'
import { Strip } from './poses/strip'
import './poses/poses.css'
import './films/films.css'
import './cameras/cameras.css'

function hintOf(desk: PointsDesk, chosen: string): string {
  if (desk.points.points.length === 0)
    return 'Measure some points that stay where they are, such as corners of a table or a door, and add each with its place.'
  if (!chosen) return 'Choose a point, then click it in the picture.'
  return `Click “${chosen}” in the picture, then in the other cameras. The wheel looks closer; drag a click to move it.`
}

function CamerasDesk({ desk, calibration }: { desk: PointsDesk; calibration: Calibration }) {
  const { cameras, result } = calibration
  const [name, setName] = useState(cameras[0].name)
  const [wanted, setWanted] = useState(0)
  const [picked, setPicked] = useState(desk.points.points[0]?.name ?? '')
  const camera = cameras.find((one) => one.name === name) ?? cameras[0]
  const frame = Math.min(wanted, Math.max(0, camera.frames - 1))
  const known = desk.points.points.some((one) => one.name === picked)
  const chosen = known ? picked : ''
  const other = (by: number) => {
    const next = cameras[cameras.indexOf(camera) + by]
    if (next) setName(next.name)
  }
  const takeBack = () =>
    chosen && desk.change(`take back ${chosen}`, withoutClick(desk.points, camera.name, chosen))
  useKeys({
    PageUp: () => other(-1),
    PageDown: () => other(1),
    Delete: takeBack,
    Backspace: takeBack,
    'ctrl+z': () => void desk.file.undo(),
    'ctrl+shift+z': () => void desk.file.redo(),
    'ctrl+y': () => void desk.file.redo(),
  })
  const note = (one: string) => {
    const count = clicksOf(desk.points, one).length
    const told = result?.stale ? undefined : result?.cameras.find(({ camera: c }) => c === one)
    return [count > 0 && String(count), told && `${told.rms_px.toFixed(1)} px`]
      .filter(Boolean)
      .join(' · ')
  }
  return (
    <div class="figure-bench cam-bench">
      <div class="figure-main">
        {camera.width > 0 ? (
          <CameraView
            key={camera.name}
            {...{ camera, frame, desk, result, chosen }}
            choose={setPicked}
          />
        ) : (
          <div class="view empty">{camera.problem}</div>
        )}
        {camera.frames > 1 && (
          <FrameSlider frames={camera.frames} frame={frame} set={setWanted} />
        )}
        <Strip
          src={(one) =>
            pointsApi.pictureUrl(cameras.find(({ name: n }) => n === one)!, 0, 240)
          }
          label="Cameras"
          names={cameras.map((one) => one.name)}
          current={camera.name}
          choose={setName}
          note={note}
        />
      </div>
      <aside class="figure-side" aria-label="Points and calibration">
        <p class="soft small">{hintOf(desk, chosen)}</p>
        {camera.problem && (
          <p class="warn small">
            {camera.name}: {camera.problem}.
          </p>
        )}
        {camera.problem && camera.width > 0 && (
          <button
            onClick={() =>
              desk.change(`take out ${camera.name}`, withoutCamera(desk.points, camera.name))
            }
          >
            Take these clicks out
          </button>
        )}
        <PointTable
          {...{ desk, result, chosen }}
          camera={camera.name}
          choose={setPicked}
        />
        <CameraErrors result={result} camera={camera.name} />
        <CalibrateCard desk={desk} calibration={calibration} />
        <details>
          <summary>A calibration made elsewhere</summary>
          <SendFiles place="calibration" words="Drop its file (.yml .json .txt .toml .xml)." />
        </details>
      </aside>
    </div>
  )
}

export function CamerasPage() {
  const { project } = useStudio()
  const desk = usePoints()
  const { calibration } = desk
  if (!calibration) return <main class="empty">Reads the points …</main>
  return (
    <main class="page whole poses films">
      <h1 class="hidden">Cameras</h1>
      {calibration.problem && <p class="bad small cam-problem">{calibration.problem}</p>}
      {calibration.cameras.length > 0 ? (
        <CamerasDesk desk={desk} calibration={calibration} />
      ) : (
        <div class="empty">
          <h2>No cameras</h2>
          {project.poses.length > 0 || <p>They come with the films.</p>}
          <SendFiles
            place="shot"
            shot={calibration.shots[0]?.name}
            folder
            words="Drop the films: a video of each camera, or its folder of numbered pictures."
          />
        </div>
      )}
    </main>
  )
}
