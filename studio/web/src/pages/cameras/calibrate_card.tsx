// From clicks to cameras: where the lenses come from, the calibration, and what it told.
import { useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { percent, sentence } from '../../words'
import { pointsApi } from './points_api'
import type { Calibration } from './points_api'
import { lacking } from './points_model'
import type { PointsDesk } from './use_points'

const kSquare_mm = 22

/** How exactly the clicks placed a camera. */
export function CameraErrors({ result, camera }: Pick<Calibration, 'result'> & { camera: string }) {
  const found = result?.stale ? undefined : result?.cameras.find((one) => one.camera === camera)
  if (!found) return null
  return (
    <p class="small cam-errors">
      <b>{camera}</b>: clicks {found.rms_px.toFixed(1)} px off in the mean; its place is known to{' '}
      {found.place_error_mm.toFixed(0)} mm
      {found.focal_error > 0 && `, its focal length to ${percent(found.focal_error, 1)}`}.
    </p>
  )
}

/** Shots whose steps take another calibration. */
function Takers({ desk, shots }: { desk: PointsDesk; shots: Calibration['shots'] }) {
  const { complain, tell } = useStudio()
  const others = shots.filter((one) => !one.ours && one.calibration)
  return (
    <>
      {others.map(({ name, calibration }) => (
        <div key={name} class="stack small">
          <p class="warn">
            Shot {name} takes its cameras from {calibration}.
          </p>
          <button
            onClick={() =>
              pointsApi
                .use(name)
                .then((now) => {
                  desk.take(now)
                  tell(`Shot ${name} takes calibration.yml.`)
                })
                .catch(complain)
            }
          >
            Take calibration.yml for {name}
          </button>
        </div>
      ))}
    </>
  )
}

export function CalibrateCard({ desk, calibration }: { desk: PointsDesk; calibration: Calibration }) {
  const { running, complain, tell, reload } = useStudio()
  const { result, offers } = calibration
  const [lenses, setLenses] = useState(result?.lenses ?? '')
  const [square, setSquare] = useState(String(result?.square_mm || kSquare_mm))
  const [busy, setBusy] = useState(false)
  const known = offers.includes(lenses) ? lenses : ''
  const lack = lacking(desk.points, calibration.cameras, known !== '')
  const ofBoard = known !== '' && !/\.ya?ml$/i.test(known)
  const calibrate = async () => {
    setBusy(true)
    try {
      await desk.file.save()
      desk.take(await pointsApi.calibrate(known, Number(square.replace(',', '.')) || 0))
      tell('The cameras are calibrated: calibration.yml.')
      await reload()
    } catch (error) {
      complain(error)
    } finally {
      setBusy(false)
    }
  }
  return (
    <section class="stack" aria-labelledby="cam-calibrate-title">
      <h2 id="cam-calibrate-title">Calibrate</h2>
      <label class="cam-field">
        Lenses
        <select value={known} onChange={(event) => setLenses(event.currentTarget.value)}>
          <option value="">from the points</option>
          {offers.map((one) => (
            <option key={one} value={one}>
              {one}
            </option>
          ))}
        </select>
      </label>
      {ofBoard && (
        <label class="cam-field">
          A square of the board, mm
          <input value={square} onInput={(event) => setSquare(event.currentTarget.value)} />
        </label>
      )}
      {lack && <p class="small soft">{lack}</p>}
      <button
        class="main"
        disabled={busy || running !== null || lack !== '' || desk.file.failed !== ''}
        onClick={() => void calibrate()}
      >
        {busy ? 'Calibrates …' : 'Calibrate the cameras'}
      </button>
      {result?.stale && (
        <p class="small warn" role="status">
          The points have changed since the last calibration.
        </p>
      )}
      {result && !result.stale && (
        <p class="small" role="status">
          {result.gone ? 'calibration.yml is another one by now.' : 'calibration.yml is up to date.'}
        </p>
      )}
      {result && !result.gone && <Takers desk={desk} shots={calibration.shots} />}
      {result && !result.stale && result.warnings.length > 0 && (
        <ul class="small warn cam-warnings">
          {result.warnings.map((one) => (
            <li key={one}>{sentence(one)}</li>
          ))}
        </ul>
      )}
    </section>
  )
}
