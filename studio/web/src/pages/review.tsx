// Review: a pose or the film before and after a change, beside each other; approved, or sent back.
import { useEffect, useState } from 'preact/hooks'

import { useStudio } from '../state'
import { useLoaded } from './poses/load'
import { Differences } from './review/differences'
import { FigurePair } from './review/figure_pair'
import { FilmPair } from './review/film_pair'
import { kGains } from './review/pair'
import type { Mode } from './review/pair'
import { PicturePair } from './review/picture_pair'
import { reviewApi } from './review/review_api'
import type { Reviews, Subject, Version } from './review/review_api'
import { firstPair, isThere, nameOf, sightsOf, standing, versionWords } from './review/review_model'
import type { Sight } from './review/review_model'
import { Verdict } from './review/verdict'
import './poses/poses.css'
import './review/review.css'

const kModes: Record<Mode, string> = {
  side: 'Side by side',
  slider: 'Slider',
  difference: 'Difference',
  distance: 'Distance',
}

/** How soon the end of a run that another program has begun is looked for. */
const kAgain_ms = 1500

/** What there is to look at, asked for again when something was made. */
function useReviews(): { reviews: Reviews | null; set: (reviews: Reviews) => void } {
  const { version, complain } = useStudio()
  const [reviews, set] = useState<Reviews | null>(null)
  useEffect(() => {
    let wanted = true
    let later = 0
    const ask = () =>
      reviewApi.all().then(
        (all) => {
          if (!wanted) return
          set(all)
          if (all.running) later = setTimeout(ask, kAgain_ms)
        },
        (error) => wanted && complain(error),
      )
    void ask()
    return () => {
      wanted = false
      clearTimeout(later)
    }
  }, [version, complain])
  return { reviews, set }
}

export function ReviewPage() {
  const { reviews, set } = useReviews()
  const [chosen, choose] = useState<string | null>(null)
  if (!reviews) return <main class="empty">Looks for earlier results …</main>
  const subject =
    reviews.subjects.find((one) => one.pose === chosen) ??
    reviews.subjects.find((one) => one.versions.some(isThere))
  if (!subject)
    return (
      <main class="empty">
        <h1>Nothing was made yet</h1>
        <p>Press Run. Each result is kept, and stands here beside the one that follows it.</p>
      </main>
    )
  return (
    <main class="page poses review">
      <h1 class="hidden">Review</h1>
      <aside class="side" aria-label="What to look at">
        <ul class="list">
          {reviews.subjects.map((one) => {
            const { words, grade } = standing(one)
            return (
              <li key={one.pose}>
                <button
                  aria-current={one === subject ? 'true' : undefined}
                  onClick={() => choose(one.pose)}
                >
                  <span class="name">{nameOf(one.pose)}</span>
                  {words && <span class={`tag ${grade}`}>{words}</span>}
                </button>
              </li>
            )
          })}
        </ul>
      </aside>
      <Reviewed key={subject.pose} subject={subject} reviews={reviews} changed={set} />
    </main>
  )
}

function Reviewed(props: {
  subject: Subject
  reviews: Reviews
  changed: (reviews: Reviews) => void
}) {
  const { subject } = props
  const first = firstPair(subject.versions)
  // '' follows what is made: the newest, and the one before it.
  const [picked, pick] = useState({ before: '', after: '' })
  const find = (id: string) => subject.versions.find((one) => one.id === id)
  const after = find(picked.after) ?? find(first.after)
  const earlier = picked.before || (after?.id === first.after ? first.before : '')
  const before = (after && find(earlier) !== after && find(earlier)) || null
  const compared = useLoaded(
    async () => (before && after ? reviewApi.compare(subject.pose, before.id, after.id) : null),
    [subject.pose, before?.id, after?.id],
  )
  if (!after)
    return (
      <div class="empty">
        <h2>Nothing of {subject.pose || 'the film'} yet</h2>
        <p>
          {subject.versions.some((one) => one.gone.length > 0)
            ? 'Its results were cleaned away. Press Run to make it again.'
            : 'Press Run to make it.'}
        </p>
      </div>
    )
  return (
    <div class="rv-desk">
      <Looking subject={subject} before={before} after={after} />
      <aside class="side rv-words" aria-label="Before and after">
        <div class="stack">
          <Versions
            label="Before"
            versions={subject.versions}
            chosen={before}
            choose={(id) => pick({ before: id, after: after.id })}
          />
          <Versions
            label="After"
            versions={subject.versions}
            chosen={after}
            choose={(id) => pick({ before: before?.id ?? '', after: id })}
          />
          {!before && (
            <p class="small soft">
              There is no other result yet. Change something and press Run: both stand here then.
            </p>
          )}
        </div>
        <Verdict
          reviews={props.reviews}
          subject={subject}
          version={after}
          changed={props.changed}
          look={(id) => pick({ before: id, after: first.after })}
        />
        {before && <Differences compared={compared.value} />}
      </aside>
    </div>
  )
}

function Versions(props: {
  label: string
  versions: Version[]
  chosen: Version | null
  choose: (id: string) => void
}) {
  const id = `rv-${props.label}`
  return (
    <div class="rv-version">
      <label for={id}>{props.label}</label>
      <select
        id={id}
        value={props.chosen?.id ?? ''}
        onChange={(event) => props.choose(event.currentTarget.value)}
      >
        {!props.chosen && <option value="">none</option>}
        {props.versions.map((version) => (
          <option key={version.id} value={version.id} disabled={!isThere(version)}>
            {versionWords(version)}
          </option>
        ))}
      </select>
    </div>
  )
}

function Looking(props: { subject: Subject; before: Version | null; after: Version }) {
  const { subject, before, after } = props
  const sights = sightsOf(before, after)
  const [key, setKey] = useState('')
  const [wanted, setMode] = useState<Mode>('side')
  const [gain, setGain] = useState(4)
  const sight = sights.find((one) => one.key === key) ?? sights[0]
  const modes = (Object.keys(kModes) as Mode[]).filter(
    (one) => one !== 'distance' || sight?.key === '3d',
  )
  const mode = modes.includes(wanted) ? wanted : 'side'
  return (
    <section class="rv-looking" aria-label={nameOf(subject.pose)}>
      <div class="tools row">
        {sights.length > 0 && <Sights {...{ sights, sight, choose: setKey }} />}
        {before && sight && (
          <div class="row end">
            {mode === 'difference' && (
              <div class="choice" role="group" aria-label="How many times brighter">
                {kGains.map((one) => (
                  <button key={one} aria-pressed={one === gain} onClick={() => setGain(one)}>
                    × {one}
                  </button>
                ))}
              </div>
            )}
            <div class="choice" role="group" aria-label="How both are shown">
              {modes.map((one) => (
                <button key={one} aria-pressed={one === mode} onClick={() => setMode(one)}>
                  {kModes[one]}
                </button>
              ))}
            </div>
          </div>
        )}
      </div>
      <Sighted {...{ subject, before, after, sight, mode, gain }} />
      {mode === 'difference' && sight && before && (
        <p class="small soft rv-hint">
          Black is the same; colours are what differs, {gain === 1 ? 'as it is' : `${gain} times brighter`}.
        </p>
      )}
    </section>
  )
}

function Sights(props: { sights: Sight[]; sight: Sight; choose: (key: string) => void }) {
  return (
    <select
      aria-label="What to look at"
      value={props.sight.key}
      onChange={(event) => props.choose(event.currentTarget.value)}
    >
      {props.sights.map((one) => (
        <option key={one.key} value={one.key}>
          {one.words}
        </option>
      ))}
    </select>
  )
}

function Sighted(props: {
  subject: Subject
  before: Version | null
  after: Version
  sight: Sight | undefined
  mode: Mode
  gain: number
}) {
  const { subject, sight, ...rest } = props
  if (!sight)
    return (
      <div class="empty">
        <p>
          {rest.before
            ? 'These two have nothing in common to look at; the figures stand beside.'
            : 'This result has no picture, film or mesh.'}
        </p>
      </div>
    )
  if (sight.key === '3d') return <FigurePair key="3d" pose={subject.pose} {...rest} />
  const Shown = sight.film ? FilmPair : PicturePair
  return <Shown key={sight.key} path={sight.key} {...rest} />
}
