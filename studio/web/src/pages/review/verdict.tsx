// What somebody says of a result, and what was said before.
import { useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { reviewApi } from './review_api'
import type { Reviews, Said, Subject, Version } from './review_api'
import { saidWords, timeWords } from './review_model'

export function Verdict(props: {
  reviews: Reviews
  subject: Subject
  version: Version
  changed: (reviews: Reviews) => void
  look: (version: string) => void
}) {
  const { reviews, subject, version, changed } = props
  const { complain } = useStudio()
  const [note, setNote] = useState('')
  const say = (verdict: string) =>
    reviewApi
      .say({ pose: subject.pose, version: version.id, verdict, note }, reviews.revision)
      .then((all) => {
        setNote('')
        changed(all)
      })
      .catch((error) => {
        complain(error)
        void reviewApi.all().then(changed)
      })
  const takeBack = (index: number) =>
    reviewApi.takeBack(index, reviews.revision).then(changed).catch(complain)
  return (
    <section class="stack" aria-label="What you say of it">
      <label for="rv-note">
        {version.now ? 'Of the result of now' : 'Of the result that is shown as after'}
      </label>
      <textarea
        id="rv-note"
        rows={3}
        placeholder="A note; what is to be changed"
        value={note}
        onInput={(event) => setNote(event.currentTarget.value)}
      />
      <div class="row">
        <button class="main" onClick={() => say('approved')}>
          Approve
        </button>
        <button
          disabled={note.trim() === ''}
          title={note.trim() === '' ? 'Say in the note what is to be changed' : undefined}
          onClick={() => say('sent back')}
        >
          Send back
        </button>
      </div>
      {reviews.problem && <p class="small bad">{reviews.problem}</p>}
      {subject.reviews.length > 0 && (
        <ul class="rv-said">
          {subject.reviews.map((said) => (
            <SaidOnce key={said.index} said={said} look={props.look} takeBack={takeBack} />
          ))}
        </ul>
      )}
    </section>
  )
}

function SaidOnce(props: {
  said: Said
  look: (version: string) => void
  takeBack: (index: number) => void
}) {
  const { said } = props
  const grade = said.holds ? (said.verdict === 'approved' ? 'good' : 'bad') : 'warn'
  return (
    <li>
      <div class="row spread">
        <b class={`small ${grade}`}>{saidWords(said)}</b>
        <button
          class="quiet small"
          aria-label={`Take back: ${saidWords(said)}`}
          onClick={() => props.takeBack(said.index)}
        >
          Take back
        </button>
      </div>
      {said.note && <p>{said.note}</p>}
      <div class="row small soft">
        <span>{timeWords(said.when)}</span>
        {!said.holds && said.version && (
          <button class="quiet small" onClick={() => props.look(said.version)}>
            Look at it
          </button>
        )}
        {!said.holds && !said.version && <span>not there any more</span>}
      </div>
    </li>
  )
}
