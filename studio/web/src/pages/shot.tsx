// A filmed shot: which frames show which pose, where the camera stood, and the pictures between.
import { useState } from 'preact/hooks'

import { useKeys } from '../keys'
import { useStudio } from '../state'
import { count } from '../words'
import { CameraCard } from './shot/camera_card'
import { ClickBench, ClickList, hintOf, useClicking } from './shot/click_bench'
import { FilmStrip, withShow } from './shot/film_strip'
import { PartsForm } from './shot/parts_fields'
import { QuickLine, useQuick } from './shot/quick'
import { ResultCard, ResultView } from './shot/result_view'
import { SetupForm } from './shot/setup_form'
import { shotApi } from './shot/shot_api'
import type { Film, Shot } from './shot/shot_api'
import { useShot } from './shot/use_shot'
import type { ShotDesk } from './shot/use_shot'
import '../view/frame_view.css'
import './shot/shot.css'

const kModes = ['Film', 'Camera', 'Result', 'Set-up'] as const
type Mode = (typeof kModes)[number]

/** Changes with each new result of a step: another picture needs another address. */
function useResultVersion(step: string): string {
  const { steps } = useStudio()
  const one = steps.steps.find((other) => other.step === step)
  return one ? `${one.seconds} ${one.state}` : ''
}

function ModeChoice(props: { mode: Mode; set: (mode: Mode) => void }) {
  return (
    <div class="choice shot-modes" role="group" aria-label="What is shown">
      {kModes.map((name, i) => (
        <button
          key={name}
          aria-pressed={name === props.mode}
          title={`${name} (${i + 1})`}
          onClick={() => props.set(name)}
        >
          {name}
        </button>
      ))}
    </div>
  )
}

function FilmCard({ film }: { film: Film }) {
  const other = [
    film.camera === 'moving' && 'moving camera',
    film.mattes && `mattes ${film.mattes}`,
    film.plate && `empty set ${film.plate}`,
    film.holdout && `holdout ${film.holdout}`,
    film.set && `set ${film.set}`,
  ].filter(Boolean)
  return (
    <section class="stack" aria-label="Film">
      <h2 class="shot-title">Film</h2>
      <p class="small">
        <code title={film.film}>{film.film}</code>
        <br />
        {count(film.frames.length, 'picture')}, {film.fps} a second
        {film.width > 0 && `, ${film.width} × ${film.height}`}
      </p>
      {other.length > 0 && <p class="small soft">{other.join(', ')}</p>}
      {film.problem && <p class="small bad">{film.problem}</p>}
    </section>
  )
}

function CameraView({ shot, version }: { shot: Shot; version: string }) {
  if (!shot.located?.has_picture)
    return (
      <section class="view shot-none">
        <p>The camera is not found yet: press Find the camera.</p>
      </section>
    )
  return (
    <section class="view shot-outlines" aria-label="Outlines over the film">
      <img
        src={shotApi.pictureUrl('located', 0, 2560, version)}
        alt="The mesh’s outlines over the filmed frames"
      />
      <p class="caption-chip">
        <span class="key green" /> mesh and film agree
        <span class="key orange" /> the filmed figure is larger
        <span class="key blue" /> it is smaller
      </p>
    </section>
  )
}

function Desk({ shot, film, desk }: { shot: Shot; film: Film; desk: ShotDesk }) {
  const { project } = useStudio()
  const [mode, setMode] = useState<Mode>(shot.finished ? 'Result' : 'Film')
  const [wanted, setWanted] = useState(film.shows[0]?.frame ?? 0)
  const at = Math.max(
    0,
    film.frames.findIndex((one) => one.frame === wanted),
  )
  const frame = film.frames[at]?.frame ?? 0
  const clicking = useClicking(desk, frame)
  const quick = useQuick(desk, film, frame, clicking.here.length)
  const located = useResultVersion('locate')
  const made = useResultVersion('composite')
  const choose = (next: number) => {
    setWanted(next)
    if (mode !== 'Film') setMode('Film')
  }
  const step = (by: number) => {
    const next = film.frames[at + by]
    if (next && mode === 'Film') setWanted(next.frame)
  }
  useKeys({
    '1': () => setMode('Film'),
    '2': () => setMode('Camera'),
    '3': () => setMode('Result'),
    '4': () => setMode('Set-up'),
    o: quick.toggle,
    PageUp: () => step(-1),
    PageDown: () => step(1),
    ...(mode === 'Film' ? { ArrowLeft: () => step(-1), ArrowRight: () => step(1) } : {}),
  })
  const shows = film.shows.find((show) => show.frame === frame)?.pose ?? ''
  return (
    <main class="page shot">
      <h1 class="hidden">Shot</h1>
      <div class="side">
        <ModeChoice mode={mode} set={setMode} />
        {mode === 'Film' && <FilmCard film={film} />}
        {mode === 'Film' && <ClickList clicking={clicking} desk={desk} />}
        {(mode === 'Film' || mode === 'Camera') && (
          <CameraCard located={shot.located} film={film} frame={frame} choose={choose} />
        )}
        {mode === 'Set-up' && <FilmCard film={film} />}
        {mode === 'Result' && <ResultCard finished={shot.finished} />}
        {shot.clicks?.problem && <p class="small warn">{shot.clicks.problem}</p>}
      </div>
      <div class="shot-work">
        {mode === 'Film' && (
          <>
            <ClickBench
              film={film}
              desk={desk}
              clicking={clicking}
              frame={frame}
              outlines={quick.picture}
            />
            <QuickLine quick={quick} hint={hintOf(clicking, shows)} />
            <FilmStrip
              film={film}
              poses={project.poses.map((pose) => pose.name)}
              clicks={desk.clicks.clicks}
              current={frame}
              choose={setWanted}
              show={(number, pose) =>
                void desk.save(({ shot: now }) => ({
                  film: now!.film,
                  fps: now!.fps,
                  shows: withShow(now!.shows, number, pose),
                }))
              }
            />
          </>
        )}
        {mode === 'Set-up' && <PartsForm film={film} offers={shot.offers} desk={desk} />}
        {mode === 'Camera' && <CameraView shot={shot} version={located} />}
        {mode === 'Result' &&
          (shot.finished ? (
            <ResultView finished={shot.finished} version={made} />
          ) : (
            <section class="view shot-none">
              <p>Nothing made yet: press Make the pictures.</p>
            </section>
          ))}
      </div>
    </main>
  )
}

export function ShotPage() {
  const desk = useShot()
  if (!desk.shot) return <main class="empty">Reading the shot…</main>
  if (!desk.shot.shot) return <SetupForm shot={desk.shot} desk={desk} />
  return <Desk shot={desk.shot} film={desk.shot.shot} desk={desk} />
}
