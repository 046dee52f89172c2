// Marks: pairs of places on the tracked actor and on the scan that shall move as he does.
import { useEffect, useMemo, useState } from 'preact/hooks'

import { api } from '../api'
import { Bar } from '../bar'
import { useStudio } from '../state'
import { SendFiles } from '../uploads/send_files'
import { percent, sentence, stepName } from '../words'
import '../view/frame_view.css'
import './landmarks/landmarks.css'
import type { Surfaces } from './landmarks/looking'
import { PairBench, useLooks } from './landmarks/pick_bench'
import { PickFiles } from './landmarks/pick_files'
import { withSheetFromOutside, withSuggestions } from './landmarks/pick_history'
import { usePicking } from './landmarks/picking'
import { SurfaceStage, useMeshSurface } from './landmarks/surface'
import { kBody, kScan, MarkSides, marksApi } from './marks/marks_api'
import type { Marks } from './marks/marks_api'
import { useUnsavedGuard } from './poses/route'

const kSuggestions = 60
/** docs/stages/transfer.md */
const kEnough = 20
const kFewest = 4

/** The marks, and both sides of them as files of picks; read again when the project changes. */
function useMarks() {
  const { version, tell, complain } = useStudio()
  const [marks, setMarks] = useState<Marks | null>(null)
  const [, redraw] = useState(0)
  const files = useMemo(
    () => new PickFiles(new MarkSides(marksApi, setMarks), () => redraw((old) => old + 1), tell),
    [tell],
  )
  useEffect(() => {
    const load = async () => {
      const first = !files.loaded
      await files.load([kBody, kScan])
      if (files.failed) await files.save()
      if (first) offerUnconfirmed(files, await marksApi.read())
    }
    load().catch(complain)
  }, [files, version, complain])
  useUnsavedGuard(files.failed !== '')
  return { marks, files }
}

/** What `keypose landmarks suggest` wrote and nobody has confirmed is offered. */
function offerUnconfirmed(files: PickFiles, marks: Marks): void {
  const open = marks.pairs.filter((one) => !one.confirmed)
  if (open.length === 0) return
  files.history = withSheetFromOutside(withSuggestions(files.history.now, kScan, open))
}

/** Runs what moves the scan, and says how far it is. */
function TransferCard({ pairs, save }: { pairs: number; save: () => Promise<void> }) {
  const { steps, running, reload, complain } = useStudio()
  const own = steps.steps.filter((one) => one.step === 'transfer')
  const now = own.map((one) => running?.steps[one.id]).find((one) => one !== undefined)
  const failed = own.find((one) => one.state === 'failed')
  const done = own.length > 0 && own.every((one) => one.state === 'done')
  const blocked = running !== null || steps.locked_by !== ''
  const run = async () => {
    try {
      await save()
      await reload()
      const all = (await api.steps()).steps.filter((one) => one.step === 'transfer')
      await api.run({ until: all.map((one) => one.id) })
      await reload()
    } catch (error) {
      complain(error)
    }
  }
  return (
    <section class="lm-fit" aria-label="Motion">
      {running && (
        <div class="stack" style="gap:4px" role="status">
          <Bar label="The run" share={now?.fraction ?? running.overall} />
          <span class="small soft">{now?.what || 'The steps before it run first.'}</span>
        </div>
      )}
      {!running && failed && (
        <p class="small bad">
          {stepName(failed.id, steps.steps)}: {sentence(failed.error)}
        </p>
      )}
      <p class="small soft">
        {pairs < kEnough
          ? `${kEnough} to 80 are enough: two or three around each upper and lower limb, one on each hand and foot, a dozen on trunk and head.`
          : done
            ? 'The scan moves as the actor does, with these marks.'
            : 'A limb without a mark moves with the rest.'}
      </p>
      <button
        class="main lm-wide"
        data-action="register"
        disabled={blocked || pairs < kFewest || done}
        title={pairs < kFewest ? `Set ${kFewest} marks first` : 'Runs up to the moving scan (Ctrl+Enter)'}
        onClick={() => void run()}
      >
        {running ? 'Runs …' : 'Move the scan'}
      </button>
      {done && (
        <a class="button lm-wide" href="#/motion">
          Look at the motion
        </a>
      )}
    </section>
  )
}

const isMesh = (path: string) => /\.(obj|ply|off|stl|glb|gltf)$/i.test(path)

/** Sends the mesh that shall move, and its texture. */
function SendScan({ words }: { words: string }) {
  const { reload, tell, complain } = useStudio()
  const [texture, setTexture] = useState('')
  const done = async (paths: string[]) => {
    const mesh = paths.find(isMesh)
    const picture = paths.find((path) => !isMesh(path)) ?? texture
    setTexture(picture)
    if (!mesh) return tell('The texture is there; now the mesh that it belongs to.')
    try {
      await marksApi.useScan(mesh, picture)
      await reload()
      tell(`${mesh} moves as the actor does, once it is marked.`)
    } catch (error) {
      complain(error)
    }
  }
  return <SendFiles place="scan" words={words} done={(paths) => void done(paths)} />
}

function NoBody() {
  const { steps, running, reload, complain } = useStudio()
  const track = steps.steps.find((one) => one.step === 'track')
  const blocked = running !== null || steps.locked_by !== ''
  return (
    <div class="stack">
      <p>The actor’s body is found in the films first; marks are set on it.</p>
      {running && <p class="soft small">A run is at work.</p>}
      {track && (
        <button
          class="main"
          disabled={blocked}
          onClick={() => api.run({ until: [track.id] }).then(reload).catch(complain)}
        >
          Find the actor
        </button>
      )}
    </div>
  )
}

function Bench({ marks, files }: { marks: Marks; files: PickFiles }) {
  const looks = useLooks()
  const { body, scan } = marks
  const surfaces: Surfaces = {
    template: useMeshSurface(
      {
        name: kBody,
        key: `body ${body.version}`,
        there: body.there,
        load: () => marksApi.mesh('body'),
        texture: '',
        missing: body.missing,
      },
      looks.plain,
    ),
    pose: useMeshSurface(
      {
        name: kScan,
        key: `scan ${scan.version}`,
        there: scan.there,
        load: () => marksApi.mesh('scan'),
        texture: scan.textured ? marksApi.textureUrl(scan.version) : '',
        missing: scan.missing,
      },
      looks.plain,
    ),
  }
  const picking = usePicking(files, surfaces, kNoAdvice, () => marksApi.suggest(kSuggestions))
  const whole = picking.items.filter(
    (item) => item.kind === 'pair' && item.pair.template && item.pair.pose,
  )
  return (
    <PairBench
      title="Marks"
      {...{ surfaces, picking, looks }}
      advice={kNoAdvice}
      top={marks.problem ? <p class="bad small">{sentence(marks.problem)}</p> : null}
      card={(pairs) => <TransferCard pairs={pairs} save={() => files.save()} />}
    >
      <div class="lm-head">
        <h2>The actor</h2>
        <span class="small soft">found in the films</span>
      </div>
      <div class="lm-head">
        <h2>The scan</h2>
        <span class="small soft">{percent(Math.min(1, whole.length / kEnough))} of {kEnough} marks</span>
        <span class="lm-gap" />
        <details class="lm-menu">
          <summary>Another scan</summary>
          <div class="marks-scan">
            <SendScan words="Drop another mesh, with its texture." />
          </div>
        </details>
      </div>
      <SurfaceStage surface={surfaces.template} label={`${kBody}: 3D view`} />
      <SurfaceStage surface={surfaces.pose} label={`${kScan}: 3D view`} />
    </PairBench>
  )
}

const kNoAdvice: never[] = []

export function MarksPage() {
  const { marks, files } = useMarks()
  if (!marks) return <main class="empty">Reads the marks …</main>
  if (marks.body.there && marks.scan.there) return <Bench marks={marks} files={files} />
  return (
    <main class="empty">
      <h1>A scan that moves as the actor does</h1>
      <p>
        Marks say which place of the one is which of the other. Without them, the actor’s own body is
        what moves.
      </p>
      {marks.scan.there ? (
        <p class="good">The scan is there.</p>
      ) : (
        <SendScan words="Drop the mesh that shall move (.obj .ply .glb .stl), with its texture." />
      )}
      {marks.body.there ? <p class="good">The actor is found.</p> : <NoBody />}
      {marks.problem && <p class="bad">{sentence(marks.problem)}</p>}
    </main>
  )
}
